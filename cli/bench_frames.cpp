// carat bench frames: how fast a device draws the flights that come with Carat.
#include <fmt/core.h>

#include <algorithm>
#include <chrono>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/deadline.hpp"
#include "carat/globe/error.hpp"
#include "carat/render/refiner.hpp"
#include "carat/vulkan/renderer.hpp"
#include "interrupt.hpp"
#include "pipeline_cache.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;
using Size = std::array<int, 2>;

struct Options {
    std::string file, csv;
    std::vector<Size> sizes{{1280, 1024}, {1920, 1200}, {3840, 2160}};
    std::optional<Geodetic> place;
    int frames = 120;
    double error = 1;
    RendererOptions renderer;
    bool json = false;
};

struct Row {
    std::string flight;
    Size size{};
    std::uint64_t frames = 0, triangles = 0, most_triangles = 0;
    bench::Spread device_ms, refine_ms;
    double device_total_ms = 0, wall_ms = 0, stall_ms = 0;  // of all frames

    double per_device_second(std::uint64_t n) const {
        return device_total_ms > 0 ? 1000 * static_cast<double>(n) / device_total_ms : 0;
    }
    double frames_per_second() const { return 1000 * static_cast<double>(frames) / wall_ms; }
};

class Flights {
  public:
    Flights(const Options& o, const std::shared_ptr<const Repository>& file)
        : o_(o), file_(file), body_(file->header().ellipsoid()) {
        RendererOptions options = o.renderer;
        options.cells = file->header().cells();
        renderer_ = std::make_unique<Renderer>(body_, length_unit(body_), options);
    }
    const std::string& device() const { return renderer_->device_name(); }

    // Each frame is refined while the device draws the one before.
    Row fly(const FlightPath& path, const Size& size) {
        const Flight flight(body_, path.keyframes);
        RefinerOptions limits;
        limits.triangles = std::numeric_limits<std::uint64_t>::max();
        Refiner refiner(file_, limits);
        Row row;
        row.flight = path.name;
        row.size = size;
        std::vector<double> device, refine;
        const auto land = [&] {
            const FrameCounters c = renderer_->collect().counters;
            device.push_back(c.gpu_ms);
            row.device_total_ms += c.gpu_ms;
            row.stall_ms += c.stall_ms;
        };
        const auto start = std::chrono::steady_clock::now();
        RefinedFrame frame;
        for (int k = 0; k < o_.frames; ++k) {
            ViewRequest where = flight.at(flight.duration() * k / std::max(1, o_.frames - 1));
            where.width = size[0];
            where.image_height = size[1];
            const View view(body_, where);
            refiner.frame(view, {o_.error, 0}, {}, frame);
            if (!frame.converged) throw Error(ErrorCode::limit, "a view takes more memory than 2 GiB");
            refine.push_back(frame.counters.total_ms);
            row.triangles += frame.counters.triangles;
            row.most_triangles = std::max(row.most_triangles, frame.counters.triangles);
            DrawRequest request;
            request.camera = view.camera();
            request.skip_back_patches = true;
            if (renderer_->frames_in_flight() == kFramesInFlight) land();
            renderer_->submit(request, frame.draw);
        }
        while (renderer_->frames_in_flight() > 0) land();
        row.wall_ms =
            std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
        row.frames = device.size();
        row.device_ms = bench::spread_of(std::move(device));
        row.refine_ms = bench::spread_of(std::move(refine));
        return row;
    }

  private:
    const Options& o_;
    std::shared_ptr<const Repository> file_;
    Ellipsoid body_;
    std::unique_ptr<Renderer> renderer_;
};

std::string size_text(const Size& s) { return fmt::format("{}x{}", s[0], s[1]); }

void print(const std::string& device, const std::vector<Row>& rows) {
    fmt::print("{}\n", device);
    fmt::print("{:<17} {:>9} {:>6} {:>12} {:>24} {:>10} {:>9} {:>8} {:>8} {:>8}\n", "flight", "size",
               "frames", "triangles", "device ms p50/p99/worst", "device fps", "Mtri/s", "wall fps", "refine",
               "stall");
    for (const Row& r : rows)
        fmt::print(
            "{:<17} {:>9} {:>6} {:>12} {:>8.2f}{:>8.2f}{:>8.2f} {:>10.1f} {:>9.1f} {:>8.1f} {:>8.2f} "
            "{:>8.2f}\n",
            r.flight, size_text(r.size), r.frames, grouped(r.triangles / r.frames), r.device_ms.median,
            r.device_ms.p99, r.device_ms.worst, r.per_device_second(r.frames),
            r.per_device_second(r.triangles) / 1e6, r.frames_per_second(), r.refine_ms.median, r.stall_ms);
}

Json json_of(const std::string& device, const std::vector<Row>& rows) {
    Json list = Json::array();
    for (const Row& r : rows)
        list.push_back(
            {{"flight", r.flight},
             {"width", r.size[0]},
             {"height", r.size[1]},
             {"frames", r.frames},
             {"triangles", r.triangles},
             {"most_triangles", r.most_triangles},
             {"device_ms",
              {{"p50", r.device_ms.median}, {"p99", r.device_ms.p99}, {"worst", r.device_ms.worst}}},
             {"device_frames_per_second", r.per_device_second(r.frames)},
             {"device_triangles_per_second", r.per_device_second(r.triangles)},
             {"frames_per_second", r.frames_per_second()},
             {"refine_ms_p50", r.refine_ms.median},
             {"stall_ms", r.stall_ms}});
    return {{"device", device}, {"rows", list}};
}

std::string csv_of(const std::vector<Row>& rows) {
    std::string csv =
        "flight,width,height,frames,triangles,most_triangles,device_p50_ms,device_p99_ms,device_worst_ms,"
        "device_fps,device_triangles_per_s,wall_fps,refine_p50_ms,stall_ms\n";
    for (const Row& r : rows)
        csv += fmt::format("{},{},{},{},{},{},{:.4f},{:.4f},{:.4f},{:.2f},{:.0f},{:.2f},{:.4f},{:.4f}\n",
                           r.flight, r.size[0], r.size[1], r.frames, r.triangles, r.most_triangles,
                           r.device_ms.median, r.device_ms.p99, r.device_ms.worst,
                           r.per_device_second(r.frames), r.per_device_second(r.triangles),
                           r.frames_per_second(), r.refine_ms.median, r.stall_ms);
    return csv;
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    const auto file = Repository::open(o.file);
    const auto paths = bench::shipped_flights(file, o.place);
    Flights flights(o, file);
    Progress progress("flights", globals.quiet);
    std::vector<Row> rows;
    for (const Size& size : o.sizes)
        for (const FlightPath& path : paths) {
            if (!progress.update(fmt::format("{}, {}", path.name, size_text(size)), rows.size(),
                                 o.sizes.size() * paths.size()))
                return kInterrupted;
            rows.push_back(flights.fly(path, size));
        }
    progress.finish();
    if (o.json)
        fmt::print("{}\n", json_of(flights.device(), rows).dump(2));
    else
        print(flights.device(), rows);
    write_text(o.csv, csv_of(rows));
    return kSuccess;
}

constexpr const char* kFooter = R"(
Flies the paths that come with Carat (see carat fly --help), every frame converged to --error without --spacing, and draws them
at each size. Device milliseconds are by the device's time stamps, from the first to the last drawing command of a frame, and the
frames and triangles a second by them; "wall fps" has all of it, refinement and the picture's way back to the host
included, a frame being refined while the one before is drawn. "stall": milliseconds of the flight in which the host waited to
upload.

Examples:
  carat bench frames california.carat
  carat bench frames california.carat --sizes 640x512 --frames 30 --device llvmpipe)";

}  // namespace

void add_bench_frames(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("frames", "Frames and triangles a second, by picture size");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    add_value(sub, "--sizes", "WxH,...", "Pixels (default 1280x1024,1920x1200,3840x2160)",
              [o](const std::string& text) { o->sizes = parse_picture_sizes(text); });
    add_place(sub, "Where the flights lead (default 36.58,-118.29)",
              [o](const Geodetic& at) { o->place = at; });
    sub.add_option("--error", o->error, "Greatest error on the screen, pixels (default 1)")
        ->check(CLI::PositiveNumber);
    sub.add_option("--frames", o->frames, "Of each flight (default 120)")->check(between(2, 1'000'000));
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    add_pipeline_cache(sub, o->renderer.pipeline_cache);
    sub.add_option("--csv", o->csv, "Also write the table here");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
