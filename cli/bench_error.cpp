// carat bench error: what a picture costs against how far it is from the truth.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/deadline.hpp"
#include "carat/bench/surface_distance.hpp"
#include "carat/bench/svg.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/build.hpp"
#include "carat/render/refiner.hpp"
#include "carat/vulkan/renderer.hpp"
#include "interrupt.hpp"
#include "layer_arguments.hpp"
#include "pipeline_cache.hpp"
#include "progress.hpp"
#include "scratch_folder.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    LayerArguments layers;
    std::vector<double> tolerances{0.5, 1, 4, 16}, thresholds{0.25, 0.5, 1, 2, 4, 8};
    std::vector<std::string> paths{"orbit-to-ground", "mountain-skim"};
    std::optional<Geodetic> place;
    int views = 12, points = 500;
    std::array<int, 2> size{1280, 720};
    RendererOptions renderer;
    std::string csv, svg, keep;
    bool json = false;
};

// All views of one file at one threshold.
struct Row {
    double tolerance = 0, threshold = 0;                   // metres, pixels
    std::uint64_t file_bytes = 0, bytes = 0, decoded = 0;  // read and decoded, over all views
    double triangles = 0, refine_ms = 0, gpu_ms = 0;       // means of a view
    std::uint64_t points = 0;
    bench::ErrorSpread metres, pixels;
    double excess = 0;  // pixels: greatest error beyond threshold + tolerance, as seen; <= 0: none
};

std::string build(const Options& o, double tolerance, const std::filesystem::path& folder) {
    BuildOptions build;
    build.layers = o.layers.layers();
    build.tolerance = tolerance;
    build.measure = false;
    build.output = folder / fmt::format("{}.carat", number(tolerance));
    if (!std::filesystem::exists(build.output)) (void)build_repository(build);
    return build.output.string();
}

std::vector<ViewRequest> views_of(const Options& o, const std::shared_ptr<const Repository>& file) {
    std::vector<ViewRequest> out;
    for (const std::string& path : o.paths) {
        const Flight flight(file->header().ellipsoid(), bench::flight_over(file, path, o.place).keyframes);
        for (int k = 0; k < o.views; ++k) {
            out.push_back(flight.at(flight.duration() * (k + 0.5) / o.views));
            out.back().width = o.size[0];
            out.back().image_height = o.size[1];
        }
    }
    return out;
}

class ErrorBench {
  public:
    ErrorBench(const Options& o, const std::string& truth)
        : o_(o), truth_(Repository::open(truth)), distance_(truth_), body_(truth_->header().ellipsoid()) {
        RendererOptions options = o.renderer;
        options.cells = truth_->header().cells();
        renderer_ = std::make_unique<Renderer>(body_, length_unit(body_), options);
        views_ = views_of(o, truth_);
    }

    Row measure(const std::string& name, double threshold) {
        const auto file = Repository::open(name);
        RefinerOptions options;
        options.triangles = std::numeric_limits<std::uint64_t>::max();
        Refiner refiner(file, options);
        Row row;
        row.tolerance = file->header().tolerance;
        row.threshold = threshold;
        row.file_bytes = file->file_bytes();
        row.excess = -std::numeric_limits<double>::infinity();
        std::vector<double> metres, pixels;
        const double share = 1.0 / static_cast<double>(views_.size());
        for (const ViewRequest& where : views_) {
            const View view(body_, where);
            const RefinedFrame refined = refiner.frame(view, {threshold, 0});
            if (!refined.converged)
                throw Error(ErrorCode::limit, name + ": a view takes more memory than 2 GiB");
            DrawRequest request;
            request.camera = view.camera();
            request.aovs.position = true;
            const Frame frame = renderer_->draw(request, refined.draw);
            row.bytes += refined.counters.read.bytes;
            row.decoded += refined.counters.decoded;
            row.triangles += share * static_cast<double>(refined.counters.triangles);
            row.refine_ms += share * refined.counters.total_ms;
            row.gpu_ms += share * frame.counters.gpu_ms;
            compare(view, frame, row, metres, pixels);
        }
        row.points = metres.size();
        row.metres = bench::error_spread(std::move(metres));
        row.pixels = bench::error_spread(std::move(pixels));
        return row;
    }

  private:
    // Pixels evenly over the picture.
    void compare(const View& view, const Frame& frame, Row& row, std::vector<double>& metres,
                 std::vector<double>& pixels) const {
        const int count = frame.colour.width * frame.colour.height;
        for (int k = 0; k < o_.points; ++k) {
            // A step that is coprime to most widths spreads over rows and columns.
            const auto pixel =
                static_cast<int>((static_cast<std::int64_t>(k) * count) / o_.points + 7 * k) % count;
            const int x = pixel % frame.colour.width, y = pixel / frame.colour.width;
            if (frame.colour.at(x, y)[3] != 1) continue;
            Vec3 point = view.eye();
            for (std::size_t c = 0; c < 3; ++c) point[c] += static_cast<double>(frame.position.at(x, y)[c]);
            const double distance = distance_(point), seen = bench::seen_as(view, point, distance);
            metres.push_back(distance);
            pixels.push_back(seen);
            row.excess =
                std::max(row.excess, seen - row.threshold - bench::seen_as(view, point, row.tolerance));
        }
    }

    const Options& o_;
    std::shared_ptr<const Repository> truth_;
    bench::SurfaceDistance distance_;
    Ellipsoid body_;
    std::unique_ptr<Renderer> renderer_;
    std::vector<ViewRequest> views_;
};

std::string csv_of(const std::vector<Row>& rows) {
    std::string csv =
        "tolerance_m,threshold_px,file_bytes,triangles,refine_ms,gpu_ms,bytes_read,decoded,points,max_px,"
        "p999_px,"
        "rms_px,max_m,p999_m,rms_m,excess_px\n";
    for (const Row& r : rows)
        csv += fmt::format(
            "{},{},{},{:.0f},{:.3f},{:.3f},{},{},{},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f},{:.4f}\n",
            r.tolerance, r.threshold, r.file_bytes, r.triangles, r.refine_ms, r.gpu_ms, r.bytes, r.decoded,
            r.points, r.pixels.max, r.pixels.p999, r.pixels.rms, r.metres.max, r.metres.p999, r.metres.rms,
            r.excess);
    return csv;
}

Json json_of(const std::vector<Row>& rows) {
    const auto spread = [](const bench::ErrorSpread& s) {
        return Json{{"max", s.max}, {"p999", s.p999}, {"rms", s.rms}};
    };
    Json out = Json::array();
    for (const Row& r : rows)
        out.push_back({{"tolerance_m", r.tolerance},
                       {"threshold_px", r.threshold},
                       {"file_bytes", r.file_bytes},
                       {"triangles", r.triangles},
                       {"refine_ms", r.refine_ms},
                       {"gpu_ms", r.gpu_ms},
                       {"bytes_read", r.bytes},
                       {"decoded", r.decoded},
                       {"points", r.points},
                       {"error_px", spread(r.pixels)},
                       {"error_m", spread(r.metres)},
                       {"excess_px", r.excess}});
    return out;
}

void print(const std::vector<Row>& rows) {
    fmt::print("{:>5} {:>5} {:>12} {:>10} {:>9} {:>8} {:>11} {:>8} {:>7} {:>7} {:>7} {:>8} {:>8} {:>8}\n",
               "tol m", "px", "file", "triangles", "refine ms", "gpu ms", "read", "decoded", "max px",
               "99.9 %", "RMS px", "max m", "99.9 % m", "RMS m");
    for (const Row& r : rows)
        fmt::print(
            "{:>5} {:>5} {:>12} {:>10.0f} {:>9.1f} {:>8.1f} {:>11} {:>8} {:>7.3f} {:>7.3f} {:>7.3f} {:>8.2f} "
            "{:>8.2f} {:>8.2f}\n",
            r.tolerance, r.threshold, grouped(r.file_bytes), r.triangles, r.refine_ms, r.gpu_ms,
            grouped(r.bytes), r.decoded, r.pixels.max, r.pixels.p999, r.pixels.rms, r.metres.max,
            r.metres.p999, r.metres.rms);
}

std::string svg(const std::vector<Row>& rows) {
    const auto plot = [&](const char* title, const char* x_label, auto x) {
        bench::Plot out{title, x_label, "error, 99.9 %, pixels", {}};
        for (const Row& r : rows) {
            const std::string name = fmt::format("{} m", number(r.tolerance));
            if (out.series.empty() || out.series.back().name != name)
                out.series.push_back({name, {}, {}, false});
            out.series.back().x.push_back(x(r));
            out.series.back().y.push_back(r.pixels.p999);
        }
        return out;
    };
    return bench::svg_of(
        {plot("Error against threshold", "threshold, pixels", [](const Row& r) { return r.threshold; }),
         plot("Error against triangles", "triangles a view", [](const Row& r) { return r.triangles; }),
         plot("Error against bytes", "bytes read", [](const Row& r) { return static_cast<double>(r.bytes); }),
         plot("Error against time", "refinement and drawing, ms a view",
              [](const Row& r) { return r.refine_ms + r.gpu_ms; })});
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    std::optional<ScratchFolder> scratch;
    if (o.keep.empty()) scratch.emplace("error");
    const std::filesystem::path folder = scratch ? scratch->path() : std::filesystem::path(o.keep);
    std::filesystem::create_directories(folder);
    Progress progress("steps", globals.quiet);
    const std::uint64_t steps = 1 + o.tolerances.size() * (1 + o.thresholds.size());
    std::uint64_t done = 0;
    constexpr double kFiner = 32;
    if (!progress.update("building the truth", done++, steps)) return kInterrupted;
    ErrorBench bench(o,
                     build(o, *std::min_element(o.tolerances.begin(), o.tolerances.end()) / kFiner, folder));
    std::vector<Row> rows;
    for (const double tolerance : o.tolerances) {
        if (!progress.update(fmt::format("building at {} m", number(tolerance)), done++, steps))
            return kInterrupted;
        const std::string file = build(o, tolerance, folder);
        for (const double threshold : o.thresholds) {
            if (!progress.update(fmt::format("{} m, {} px", number(tolerance), number(threshold)), done++,
                                 steps))
                return kInterrupted;
            rows.push_back(bench.measure(file, threshold));
        }
    }
    progress.finish();
    if (o.json)
        fmt::print("{}\n", json_of(rows).dump(2));
    else
        print(rows);
    write_text(o.csv, csv_of(rows));
    if (!o.svg.empty()) write_text(o.svg, svg(rows));
    const bool within = std::all_of(rows.begin(), rows.end(), [](const Row& r) { return r.excess <= 1e-3; });
    if (!within) fmt::print(stderr, "an error is greater than threshold and tolerance allow\n");
    return within ? kSuccess : kFailure;
}

constexpr const char* kFooter = R"(
Builds the layers at each tolerance, flies the paths converged to each threshold, and compares points of every
picture (position channel) with the truth: the surface of the same layers built at a thirty-second of the finest tolerance.
Pixels are f d / z sec(theta), as in the bound. Bytes and diamonds are those of all views, starting cold; triangles and
milliseconds are means of a view. --spacing plays no part. The exit status is 1 if an error is greater than the threshold and,
as seen from there, the tolerance.

Example:
  carat bench error --layer california_3s.tif --layer earth_5min.tif --csv error.csv --svg error.svg)";

}  // namespace

void add_bench_error(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("error", "Run time against measured error");
    sub.footer(kFooter);
    const char* group = "Layers";
    o->layers.add_lead(sub, "Elevation models, the finest first", group)->required();
    o->layers.add_options(sub, group);
    sub.add_option("--tolerances", o->tolerances, "Metres (default 0.5,1,4,16)")
        ->delimiter(',')
        ->check(CLI::PositiveNumber);
    sub.add_option("--thresholds", o->thresholds, "Pixels (default 0.25,0.5,1,2,4,8)")
        ->delimiter(',')
        ->check(CLI::PositiveNumber);
    sub.add_option("--paths", o->paths, "Flights (default orbit-to-ground,mountain-skim)")->delimiter(',');
    add_place(sub, "Where the flights lead (default 36.58,-118.29)",
              [o](const Geodetic& at) { o->place = at; });
    sub.add_option("--views", o->views, "Of each path (default 12)")->check(between(1, 100'000));
    sub.add_option("--points", o->points, "Compared in each picture (default 500)")
        ->check(between(1, 10'000'000));
    add_value(sub, "--size", "WxH", "Pixels (default 1280x720)",
              [o](const std::string& text) { o->size = parse_picture_size(text); });
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    add_pipeline_cache(sub, o->renderer.pipeline_cache);
    sub.add_option("--keep", o->keep,
                   "Folder for the files; those in it are used again (default: none is kept)");
    sub.add_option("--csv", o->csv, "Also write the table here");
    sub.add_option("--svg", o->svg, "Also write plots here");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
