// carat bench threshold: whether every pixel keeps its threshold, as an independent ray-caster sees it.
#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/screen_evidence.hpp"
#include "carat/bench/surface_distance.hpp"
#include "carat/globe/error.hpp"
#include "carat/render/refiner.hpp"
#include "carat/render/vector.hpp"
#include "carat/vulkan/renderer.hpp"
#include "interrupt.hpp"
#include "pipeline_cache.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string file, csv;
    int views = 217;
    unsigned seed = 1;
    std::array<int, 2> size{64, 36};
    double threshold = 1, draw = 0;  // pixels; draw: what is drawn at, 0: the threshold
    Geodetic place{36.58, -118.29};
    RendererOptions renderer;
    bool json = false;
};

// Errors of pixels as shares of the threshold.
struct Tally {
    std::array<std::uint64_t, 10> tenths{};  // the last one holds all from nine tenths on
    std::uint64_t count = 0, beyond = 0;
    double greatest = 0, squares = 0;

    void add(double share, double rounding = 0) {
        ++count;
        beyond += share > 1 + rounding ? 1 : 0;
        ++tenths[static_cast<std::size_t>(std::min(9.0, 10 * share))];
        greatest = std::max(greatest, share);
        squares += share * share;
    }
    void add(const Tally& o) {
        for (std::size_t k = 0; k < tenths.size(); ++k) tenths[k] += o.tenths[k];
        count += o.count;
        beyond += o.beyond;
        greatest = std::max(greatest, o.greatest);
        squares += o.squares;
    }
    double rms() const { return count > 0 ? std::sqrt(squares / static_cast<double>(count)) : 0; }
};

struct Kind {
    std::uint64_t views = 0, disagree = 0;  // pixels: one shows the sky where the other does not
    Tally to_surface, to_drawn;

    void add(const Kind& o) {
        views += o.views;
        disagree += o.disagree;
        to_surface.add(o.to_surface);
        to_drawn.add(o.to_drawn);
    }
};

class Evidence {
  public:
    explicit Evidence(const Options& o)
        : o_(o),
          file_(Repository::open(o.file)),
          body_(file_->header().ellipsoid()),
          distance_(file_),
          rays_(file_) {
        RendererOptions options = o.renderer;
        options.cells = file_->header().cells();
        renderer_ = std::make_unique<Renderer>(body_, length_unit(body_), options);
        RefinerOptions limits;
        limits.triangles = std::numeric_limits<std::uint64_t>::max();
        refiner_ = std::make_unique<Refiner>(file_, limits);
    }

    std::vector<bench::KindOfView> views() const {
        return bench::views_by_kind(file_, o_.views, o_.seed, o_.size[0], o_.size[1], o_.place);
    }

    Kind look(const ViewRequest& where) {
        const View view(body_, where);
        const RefinedFrame refined = refiner_->frame(view, {o_.draw > 0 ? o_.draw : o_.threshold, 0});
        if (!refined.converged) throw Error(ErrorCode::limit, "a view takes more memory than 2 GiB");
        DrawRequest request;
        request.camera = view.camera();
        request.aovs.position = true;
        request.skip_back_patches = true;
        const Frame frame = renderer_->draw(request, refined.draw);
        const bench::DrawnPatches drawn(refined.draw, file_->header().cells(), view.unit());
        std::vector<Kind> rows(static_cast<std::size_t>(o_.size[1]));
        tbb::parallel_for(0, o_.size[1], [&](int y) {
            for (int x = 0; x < o_.size[0]; ++x)
                compare(view, frame, drawn, x, y, rows[static_cast<std::size_t>(y)]);
        });
        Kind out;
        for (const Kind& row : rows) out.add(row);
        out.views = 1;
        return out;
    }

  private:
    void compare(const View& view, const Frame& frame, const bench::DrawnPatches& drawn, int x, int y,
                 Kind& out) const {
        const bool covered = frame.colour.at(x, y)[3] == 1;
        if (covered) {
            Vec3 point = view.eye();
            for (std::size_t c = 0; c < 3; ++c) point[c] += static_cast<double>(frame.position.at(x, y)[c]);
            // The device returns positions as floats: 2^-23 of the distance covers their three roundings.
            const double rounding =
                bench::seen_as(view, point, std::ldexp(length(subtract(point, view.eye())), -23));
            out.to_surface.add(bench::seen_as(view, point, distance_(point)) / o_.threshold,
                               rounding / o_.threshold);
        }
        const Vec3 through = view.camera().ray(x + 0.5, y + 0.5);
        bench::SurfaceRays::Hit hit;
        const bool met = rays_.first_hit(view.eye(), scale(1 / length(through), through), hit);
        out.disagree += met != covered ? 1 : 0;
        if (met)
            out.to_drawn.add(std::min(1e9, bench::seen_as(view, hit.point, drawn.distance(hit))) /
                             o_.threshold);
    }

    const Options& o_;
    std::shared_ptr<const Repository> file_;
    Ellipsoid body_;
    bench::SurfaceDistance distance_;
    bench::SurfaceRays rays_;
    std::unique_ptr<Renderer> renderer_;
    std::unique_ptr<Refiner> refiner_;
};

using Kinds = std::vector<std::pair<std::string, Kind>>;

std::string csv_of(const Kinds& kinds) {
    std::string csv = "kind,views,direction,pixels,greatest,rms,beyond,disagree";
    for (int k = 1; k <= 10; ++k) csv += fmt::format(",to_{}_tenths", k);
    csv += '\n';
    for (const auto& [name, kind] : kinds)
        for (const auto& [direction, t] :
             {std::pair{"drawn_to_surface", kind.to_surface}, {"surface_to_drawn", kind.to_drawn}}) {
            csv += fmt::format("{},{},{},{},{:.5f},{:.5f},{},{}", name, kind.views, direction, t.count,
                               t.greatest, t.rms(), t.beyond, kind.disagree);
            for (const std::uint64_t n : t.tenths) csv += fmt::format(",{}", n);
            csv += '\n';
        }
    return csv;
}

Json json_of(const Tally& t) {
    return {{"pixels", t.count},
            {"greatest", t.greatest},
            {"overestimated", t.greatest > 0 ? Json(1 / t.greatest) : Json(nullptr)},
            {"rms", t.rms()},
            {"beyond", t.beyond},
            {"tenths", t.tenths}};
}

void print(const Kinds& kinds) {
    fmt::print("{:<13} {:>5} | {:>8} {:>8} {:>6} {:>7} {:>6} | {:>8} {:>8} {:>6} {:>7} {:>6} | {:>8}\n", "",
               "views", "drawn", "greatest", "factor", "rms", "beyond", "S", "greatest", "factor", "rms",
               "beyond", "disagree");
    const auto half = [](const Tally& t) {
        return fmt::format("{:>8} {:>8.3f} {:>6.2f} {:>7.4f} {:>6}", t.count, t.greatest, 1 / t.greatest,
                           t.rms(), t.beyond);
    };
    for (const auto& [name, kind] : kinds)
        fmt::print("{:<13} {:>5} | {} | {} | {:>8}\n", name, kind.views, half(kind.to_surface),
                   half(kind.to_drawn), kind.disagree);
    const auto histogram = [](const char* what, const Tally& t) {
        fmt::print("{}, by tenths of the threshold:", what);
        for (const std::uint64_t n : t.tenths) fmt::print(" {}", grouped(n));
        fmt::print("\n");
    };
    histogram("from the drawn to S", kinds.back().second.to_surface);
    histogram("from S to the drawn", kinds.back().second.to_drawn);
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    Progress progress("views", globals.quiet);
    Evidence evidence(o);
    Kinds kinds;
    Kind all;
    const auto views = evidence.views();
    for (std::size_t k = 0; k < views.size(); ++k) {
        if (!progress.update(views[k].kind, k, views.size())) return kInterrupted;
        auto at = std::find_if(kinds.begin(), kinds.end(),
                               [&](const auto& known) { return known.first == views[k].kind; });
        if (at == kinds.end()) at = kinds.insert(kinds.end(), {views[k].kind, {}});
        const Kind one = evidence.look(views[k].view);
        at->second.add(one);
        all.add(one);
    }
    progress.finish();
    kinds.emplace_back("together", all);
    if (o.json) {
        Json out = Json::array();
        for (const auto& [name, kind] : kinds)
            out.push_back({{"kind", name},
                           {"views", kind.views},
                           {"drawn_to_surface", json_of(kind.to_surface)},
                           {"surface_to_drawn", json_of(kind.to_drawn)},
                           {"disagree", kind.disagree}});
        fmt::print("{}\n", out.dump(2));
    } else {
        print(kinds);
    }
    write_text(o.csv, csv_of(kinds));
    if (all.to_surface.beyond + all.to_drawn.beyond == 0) return kSuccess;
    fmt::print(stderr, "{} pixels are beyond the threshold\n", all.to_surface.beyond + all.to_drawn.beyond);
    return kFailure;
}

constexpr const char* kFooter = R"(
Draws views of seven kinds, and for every pixel compares both ways: the point drawn (position channel) with the surface S
of the file, and the point of S that a ray through the pixel hits, found by marching along the file's heights, with
what is drawn at its place. Distances are those in space, as seen from the eye, and printed as shares of the threshold: the greatest,
by what factor the bound overestimates it, their RMS, and how many are beyond it (the exit status is then 1). Orbit, oblique, grazing and
valley floor (the lowest sample downhill) are near --at, the others anywhere at poles, cube corners and the antimeridian.
"disagree" counts pixels where one of the two shows the sky: silhouettes that moved by less than the threshold.

Example:
  carat bench threshold planet.carat --at 36.58,-118.29 --csv threshold.csv)";

}  // namespace

void add_bench_threshold(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("threshold", "Every pixel against an independent ray-caster");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    add_place(sub, "Where the first four kinds are (default 36.58,-118.29)",
              [o](const Geodetic& at) { o->place = at; });
    add_value(sub, "--size", "WxH", "Pixels (default 64x36)",
              [o](const std::string& text) { o->size = parse_picture_size(text); });
    sub.add_option("--error", o->threshold, "The threshold, pixels (default 1)")->check(CLI::PositiveNumber);
    sub.add_option("--draw-error", o->draw, "Draw with another one, to see that it is noticed")
        ->check(CLI::PositiveNumber);
    sub.add_option("--views", o->views, "In all (default 217)")->check(between(1, 1'000'000));
    sub.add_option("--seed", o->seed, "Of the views (default 1)");
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    add_pipeline_cache(sub, o->renderer.pipeline_cache);
    sub.add_option("--csv", o->csv, "Also write the table, with histograms, here");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
