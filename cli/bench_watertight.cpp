// carat bench watertight: no background where there must be ground.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/certain_ground.hpp"
#include "carat/bench/random_views.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/build.hpp"
#include "carat/render/refiner.hpp"
#include "carat/synth/synth.hpp"
#include "carat/vulkan/renderer.hpp"
#include "interrupt.hpp"
#include "pipeline_cache.hpp"
#include "progress.hpp"
#include "scratch_folder.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::vector<std::string> files;
    int views = 10'000;
    unsigned seed = 1;
    std::vector<std::array<int, 2>> sizes{{96, 72}, {128, 128}, {200, 100}};  // in turn
    std::optional<Geodetic> place;
    RendererOptions renderer;
    bool json = false, control = false;
};

struct Row {
    std::string file;
    std::uint64_t views = 0, pixels = 0, judged = 0, holes = 0, triangles = 0;
    double tolerance = 0;
    std::array<double, 2> error{1e9, 0};  // pixels asked for, least and greatest
    std::string first_hole;
};

struct TestPlanet {
    synth::Kind kind;
    const char* name;
    int size, inset;
    double tolerance;
};
constexpr TestPlanet kPlanets[] = {{synth::Kind::earth, "earth", 720, 256, 2},
                                   {synth::Kind::moon, "moon", 720, 256, 30},
                                   {synth::Kind::spikes, "spikes", 0, 0, 8},
                                   {synth::Kind::cliff, "cliff", 0, 0, 0.5}};

// With diamonds of 17 x 17, so that small pictures hold many patches.
std::string make_planet(const TestPlanet& p, const std::filesystem::path& folder) {
    synth::Options options;
    options.size = p.size;
    options.inset_size = p.inset;
    BuildOptions build;
    for (const synth::Written& w : synth::write(p.kind, folder / p.name, options)) {
        LayerOptions layer;
        layer.files = {(folder / p.name / w.name).string()};
        build.layers.push_back(layer);
    }
    build.body = synth::planet(p.kind, options).body;
    build.tolerance = p.tolerance;
    build.log2_cells = 4;
    build.measure = false;
    build.output = folder / fmt::format("{}.carat", p.name);
    (void)build_repository(build);
    return build.output.string();
}

class Watertight {
  public:
    Watertight(const Options& o, const std::string& file, std::uint64_t views)
        : o_(o),
          views_(views),
          repository_(Repository::open(file)),
          body_(repository_->header().ellipsoid()),
          refiner_(repository_),
          source_(repository_, o.seed, o.sizes[0][0], o.sizes[0][1], o.place),
          random_(o.seed) {
        RendererOptions options = o.renderer;
        options.cells = repository_->header().cells();
        renderer_ = std::make_unique<Renderer>(body_, length_unit(body_), options);
        row_.file = file;
        row_.tolerance = repository_->header().tolerance;
    }

    // False: interrupted.
    bool run(Progress& progress) {
        for (; row_.views < views_; ++row_.views) {
            shoot();
            if (renderer_->frames_in_flight() == kFramesInFlight) judge();
            if (!progress.update(row_.file, row_.views + 1, views_)) return false;
        }
        while (renderer_->frames_in_flight() > 0) judge();
        for (const std::string& message : renderer_->messages())
            throw Error(ErrorCode::io, "Vulkan: " + message);
        return true;
    }
    const Row& row() const { return row_; }

  private:
    struct Shot {
        bench::CertainGround ground;
        std::string name;
    };

    void shoot() {
        ViewRequest where = source_.next();
        const std::array<int, 2>& size = o_.sizes[row_.views % o_.sizes.size()];
        where.width = size[0];
        where.image_height = size[1];
        const View view(body_, where);
        const double threshold = std::exp(std::uniform_real_distribution<double>(0, std::log(16.0))(random_));
        row_.error = {std::min(row_.error[0], threshold), std::max(row_.error[1], threshold)};
        const RepositoryHeader& h = repository_->header();
        const RefinedFrame frame = refiner_.frame(view, {threshold, 0});
        row_.triangles += frame.counters.triangles;
        DrawRequest request;
        request.camera = view.camera();
        request.background = {1, 0, 1};
        request.skip_back_patches = true;
        // The middle of the list is somewhere in the middle of what is seen, often enough.
        std::vector<std::shared_ptr<const PatchMesh>> patches = frame.draw;
        if (o_.control) patches.erase(patches.begin() + static_cast<std::ptrdiff_t>(patches.size() / 2));
        renderer_->submit(request, patches);
        shots_.push_back(
            {bench::CertainGround(view, body_, h.min_height * h.quantum, frame.counters.worst_error),
             fmt::format("--eye {:.9f},{:.9f},{:.3f} --heading {:.4f} --pitch {:.4f} --fov {:.4f} "
                         "--size {}x{} --error {:.4f}",
                         where.eye.latitude, where.eye.longitude, where.height, where.heading, where.pitch,
                         where.fov, size[0], size[1], threshold)});
    }

    void judge() {
        const Frame frame = renderer_->collect();
        const Shot shot = std::move(shots_.front());
        shots_.pop_front();
        for (int y = 0; y < frame.colour.height; ++y)
            for (int x = 0; x < frame.colour.width; ++x) {
                const float* const p = frame.colour.at(x, y);
                const bool magenta = p[0] == 1 && p[1] == 0 && p[2] == 1;
                const bool ground = p[3] == 1 && !magenta, certain = shot.ground.holds(x, y);
                row_.pixels += ground || certain;
                row_.judged += certain;
                if (ground || !certain) continue;
                if (row_.holes++ == 0) row_.first_hole = fmt::format("pixel {},{} of {}", x, y, shot.name);
            }
    }

    const Options& o_;
    std::uint64_t views_;
    std::shared_ptr<const Repository> repository_;
    Ellipsoid body_;
    Refiner refiner_;
    bench::RandomViews source_;
    std::mt19937_64 random_;
    std::unique_ptr<Renderer> renderer_;
    std::deque<Shot> shots_;
    Row row_;
};

int report(const Options& o, const std::vector<Row>& rows) {
    std::uint64_t holes = 0;
    Json json = Json::array();
    if (!o.json)
        fmt::print("{:<32} {:>9} {:>7} {:>14} {:>13} {:>6} {:>14} {:>6}\n", "file", "tolerance", "views",
                   "ground pixels", "judged", "%", "triangles", "holes");
    for (const Row& r : rows) {
        holes += r.holes;
        const std::string name = std::filesystem::path(r.file).filename().string();
        if (o.json)
            json.push_back({{"file", name},
                            {"tolerance_m", r.tolerance},
                            {"views", r.views},
                            {"sizes", std::min<std::uint64_t>(r.views, o.sizes.size())},
                            {"error_px", r.error},
                            {"pixels", r.pixels},
                            {"judged", r.judged},
                            {"triangles", r.triangles},
                            {"holes", r.holes},
                            {"first_hole", r.first_hole}});
        else
            fmt::print("{:<32} {:>9} {:>7} {:>14} {:>13} {:>6.1f} {:>14} {:>6}{}\n", name, r.tolerance,
                       r.views, grouped(r.pixels), grouped(r.judged),
                       100 * static_cast<double>(r.judged) / static_cast<double>(r.pixels),
                       grouped(r.triangles), r.holes, r.holes > 0 ? "  " + r.first_hole : "");
    }
    if (o.json) fmt::print("{}\n", json.dump(2));
    return holes == 0 ? kSuccess : kFailure;
}

int run(Options o, const Globals& globals) {
    catch_interrupts();
    std::optional<ScratchFolder> scratch;
    if (o.files.empty()) {
        scratch.emplace("watertight");
        for (const TestPlanet& p : kPlanets) o.files.push_back(make_planet(p, scratch->path()));
    }
    Progress progress("views", globals.quiet);
    std::vector<Row> rows;
    for (std::size_t k = 0; k < o.files.size(); ++k) {
        // Shares that add up.
        const auto part = [&](std::size_t n) {
            return static_cast<std::uint64_t>(o.views) * n / o.files.size();
        };
        Watertight one(o, o.files[k], part(k + 1) - part(k));
        if (!one.run(progress)) return kInterrupted;
        rows.push_back(one.row());
    }
    progress.finish();
    return report(o, rows);
}

constexpr const char* kFooter = R"(
Draws random views (from orbit, oblique, grazing, near the ground; anywhere, and at poles, cube corners and edges and
the antimeridian; 1 to 16 pixels of error) before a magenta background, and counts background pixels that must show
ground: their ray meets the ellipsoid lowered by the file's least height and by what the view's error allows at that distance.
Prints how many pixels could be judged so, of all that show ground. Without FILE it makes four planets of 17 x 17 diamonds: an
earth, a moon, one of spikes, one of cliffs along the cube's edges. The exit status is 1 if there is a hole.

Examples:
  carat bench watertight
  carat bench watertight california.carat --at 36.58,-118.29 --views 1000)";

}  // namespace

void add_bench_watertight(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("watertight", "Holes in random views");
    sub.footer(kFooter);
    sub.add_option("FILE", o->files, "Files to draw (default: planets made for it)");
    sub.add_option("--views", o->views, "In all (default 10000)")->check(between(1, 100'000'000));
    sub.add_option("--seed", o->seed, "Of the views (default 1)");
    add_value(sub, "--size", "WxH[,WxH...]", "Pixels, in turn (default 96x72,128x128,200x100)",
              [o](const std::string& text) { o->sizes = parse_picture_sizes(text); });
    add_place(sub, "Half of the views are near this place", [o](const Geodetic& at) { o->place = at; });
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    add_pipeline_cache(sub, o->renderer.pipeline_cache);
    sub.add_flag("--control", o->control, "Leave out one patch of each view, to see that holes are found");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
