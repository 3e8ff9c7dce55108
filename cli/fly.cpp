// carat fly: a flight along keyframes, every frame converged or refined within a budget of time.
#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <deque>
#include <filesystem>
#include <limits>
#include <memory>
#include <optional>

#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "carat/render/detail_surface.hpp"
#include "carat/render/flight_path.hpp"
#include "carat/render/refiner.hpp"
#include "commands.hpp"
#include "flight_stats.hpp"
#include "frame_sink.hpp"
#include "interrupt.hpp"
#include "look.hpp"
#include "pipeline_cache.hpp"
#include "progress.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

struct Options {
    std::string file, path, output, stats, format = "png";
    std::optional<Geodetic> place;
    std::array<int, 2> size{1280, 720};
    double fps = 30;
    std::optional<double> budget;
    bool converged = false, json = false, overwrite = false;
    std::size_t upload = 8u << 20;
    RefineGoal goal{1, 1.5};
    RefinerOptions refiner;
    Look look;
    RendererOptions renderer;
};

constexpr const char* kFooter = R"(
--converged (the default): every frame is refined to --error and --spacing, however long that takes; the pictures are a pure
function of the file and the path, the same bytes every run. --budget MS: what is ready after so many milliseconds of
refinement is drawn, worker threads go on with the rest, and the next frame takes up there. Each frame is a step of
1/fps seconds along the path, however long drawing takes.

The path is JSON: a list of keyframes with "time" (seconds), "lat", "lon" (degrees), "height" (metres above the
ellipsoid), "heading", "pitch", "roll" and "fov" (degrees; default 0, -90, 0, 45). Between them the eye follows the geodesic,
faster the higher it is, its height changes by equal factors in equal times, and it turns without jerks.

  [{"time": 0, "lat": 20, "lon": -110, "height": 9e6, "pitch": -90},
   {"time": 8, "lat": 36, "lon": -118.5, "height": 6000, "heading": 20, "pitch": -10}]

A path round a place is {"name": TEXT, "place": [LAT, LON], "keyframes": LIST}: its keyframes may have "north" and "east"
(degrees from the place) and "above" (metres above the file's ground at the place) or "over" (the same, and the eye slows
down by it instead of by its height), and --at flies it elsewhere. Four come with Carat and are known by name:
orbit-to-ground, mountain-skim, jumps-and-turns and down-to-eye-level (Mount Whitney, California).

OUT.mp4 needs ffmpeg; any other output is a folder of frame-00001.png and so on. --stats has one CSV line a frame: the cut
and what was culled, pages and bytes read, diamonds decoded and predicted, patches uploaded, milliseconds by stage.

Examples:
  carat fly earth.carat --path descent.json --size 1280x720 -o descent.mp4
  carat fly earth.carat --path mountain-skim --at 27.99,86.93 --budget 8 --fps 60 --stats skim.csv -o frames)";

void check(const Options& o) {
    if (o.converged && o.budget) throw Error(ErrorCode::usage, "--converged and --budget exclude each other");
    if (!o.overwrite && !o.stats.empty() && std::filesystem::exists(o.stats))
        throw Error(ErrorCode::usage, o.stats + ": exists already; --overwrite replaces it");
}

FlightPath path_of(const Options& o, const std::shared_ptr<const Repository>& file) {
    FlightSite site;
    site.place = o.place;
    const auto detail = detail_of(o.look, file->header());
    site.ground = [&](const Geodetic& place) {
        if (detail) return DetailSurface(file, detail, 1).sample(lattice_position(direction(place))).height;
        return Surface(file, 1).sample(lattice_position(direction(place))).height;
    };
    return read_flight_path(o.path, site);
}

double milliseconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - start).count();
}

// Refines a frame while the device draws the one before.
class Pilot {
  public:
    using Clock = std::chrono::steady_clock;
    Pilot(const Options& o, const std::shared_ptr<const Repository>& file)
        : o_(o),
          body_(file->header().ellipsoid()),
          flight_(body_, path_of(o, file).keyframes),
          draped_(draped_colours(o.look)),
          refiner_(file, refiner_options(o, draped_, file->header())),
          sink_(o.output, o.fps, o.overwrite, o.format),
          stats_(o.stats, file->file_bytes(), o.fps, budget().milliseconds, o.goal.threshold) {
        RendererOptions options = o.renderer;
        options.cells = file->header().cells();
        options.coloured = draped_ != nullptr;
        constexpr std::size_t kGreatestFrame = 64u << 20;  // beyond it a stall is the lesser evil
        if (o.budget) options.upload_bytes = staging_bytes(std::min(o.upload, kGreatestFrame));
        renderer_ = std::make_unique<Renderer>(body_, length_unit(body_), options);
        if (const auto colours = chosen_colours(o.look)) renderer_->set_colours(*colours);
    }

    int frames() const { return static_cast<int>(std::floor(flight_.duration() * o_.fps)) + 1; }
    const FlightStats& stats() const { return stats_; }
    const Renderer& renderer() const { return *renderer_; }

    // k: from 0, in order.
    void fly(int k) {
        const auto started = Clock::now();
        FrameRow row;
        row.frame = k + 1;
        row.time = k / o_.fps;
        row.where = flight_.at(row.time);
        row.where.width = o_.size[0];
        row.where.image_height = o_.size[1];
        const ViewRequest drawn = drawn_view(o_.look, row.where);
        const View view(body_, drawn);
        refiner_.frame(view, goal(), budget(), refined_);
        if (!o_.budget && !refined_.converged)
            throw Error(ErrorCode::limit, fmt::format("frame {} needs more than --memory allows", k + 1));
        row.cut = refined_.counters;
        row.cut.worst_error /= o_.look.supersample;
        row.converged = refined_.converged;
        renderer_->submit(draw_request(o_.look, drawn, view, body_), refined_.draw);
        std::optional<Frame> done;
        if (renderer_->frames_in_flight() == kFramesInFlight) done = renderer_->collect();
        row.frame_ms = milliseconds_since(started);
        under_way_.push_back(std::move(row));
        if (done) land(*done);
    }

    void finish() {
        while (renderer_->frames_in_flight() > 0) {
            const auto started = Clock::now();
            Frame frame = renderer_->collect();
            under_way_.front().frame_ms += milliseconds_since(started);
            land(frame);
        }
        sink_.finish();
        for (const std::string& message : renderer_->messages())
            throw Error(ErrorCode::io, "Vulkan: " + message);
    }

  private:
    static RefinerOptions refiner_options(const Options& o, std::shared_ptr<const ColourRepository> colour,
                                          const RepositoryHeader& header) {
        RefinerOptions options = o.refiner;
        options.colour = std::move(colour);
        options.detail = detail_of(o.look, header);
        return options;
    }
    RefineBudget budget() const {
        RefineBudget budget;
        if (!o_.budget) return budget;
        budget.milliseconds = *o_.budget;
        budget.upload_bytes = o_.upload;
        return budget;
    }

    // In pixels as drawn.
    RefineGoal goal() const {
        RefineGoal goal = o_.goal;
        goal.threshold *= o_.look.supersample;
        goal.spacing *= o_.look.supersample;
        return goal;
    }

    void land(Frame& frame) {
        FrameRow row = std::move(under_way_.front());
        under_way_.pop_front();
        const auto started = Clock::now();
        frame.colour = shrunk(frame.colour, o_.look.supersample);
        tone_map(frame.colour, o_.look.tone);
        sink_.add(frame.colour);
        row.write_ms = milliseconds_since(started);
        row.gpu = frame.counters;
        stats_.add(row);
    }

    const Options& o_;
    Ellipsoid body_;
    Flight flight_;
    std::shared_ptr<const ColourRepository> draped_;
    Refiner refiner_;
    RefinedFrame refined_;  // the last frame's
    FrameSink sink_;
    FlightStats stats_;
    std::unique_ptr<Renderer> renderer_;
    std::deque<FrameRow> under_way_;
};

int run(Options o, const Globals& globals) {
    check(o);
    if (!o.budget) o.refiner.triangles = std::numeric_limits<std::uint64_t>::max();
    catch_interrupts();
    const auto begin = std::chrono::steady_clock::now();
    const auto file = Repository::open(o.file);
    Pilot pilot(o, file);
    const int frames = pilot.frames();
    Progress progress("frames", globals.quiet);
    for (int k = 0; k < frames; ++k) {
        pilot.fly(k);
        if (!progress.update("flying", static_cast<std::uint64_t>(k) + 1, static_cast<std::uint64_t>(frames)))
            return kInterrupted;
    }
    progress.finish();
    pilot.finish();
    if (o.json) {
        nlohmann::ordered_json json = pilot.stats().json();
        json["device"] = pilot.renderer().device_name();
        fmt::print("{}\n", json.dump(2));
    } else if (!globals.quiet) {
        fmt::print(stderr, "{}: {:.2f} s a frame on {}\n{}\n", o.output,
                   milliseconds_since(begin) / 1000 / frames, pilot.renderer().device_name(),
                   pilot.stats().text());
    }
    return kSuccess;
}

void add_refinement_options(CLI::App& sub, Options& o) {
    const char* group = "Refinement";
    sub.add_flag("--converged", o.converged, "Refine every frame to the end (the default)")->group(group);
    sub.add_option("--budget", o.budget, "Milliseconds of refinement a frame: draw what is ready then")
        ->check(between(0.1, 60'000.0))
        ->group(group);
    sub.add_option("--error", o.goal.threshold, "Greatest error on the screen, pixels (default 1)")
        ->check(CLI::PositiveNumber)
        ->group(group);
    sub.add_option("--spacing", o.goal.spacing,
                   "Greatest distance of samples on the screen, pixels, where the file has finer "
                   "ones; 0: --error alone decides (default 1.5)")
        ->check(CLI::NonNegativeNumber)
        ->group(group);
    add_value(sub, "--upload", "SIZE",
              "Of patches new to the device a frame, at most but for a few that make for "
              "progress, with --budget (default 8M)",
              [&o](const std::string& text) { o.upload = parse_size(text); })
        ->group(group);
    sub.add_option("--triangles", o.refiner.triangles, "A frame, at most, with --budget (default 16000000)")
        ->check(between(1, 2'000'000'000))
        ->group(group);
    add_value(sub, "--memory", "SIZE", "Of heights and patches kept, at most, between frames (default 2G)",
              [&o](const std::string& text) { o.refiner.bytes = parse_size(text); })
        ->group(group);
    sub.add_option("--threads", o.refiner.threads, "Workers (default: one for each core)")
        ->check(between(1, 1024))
        ->group(group);
}

}  // namespace

void add_fly(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("fly", "Draw a flight over the planet");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    sub.add_option("--path", o->path, "Keyframes: a file, or the name of a path that comes with Carat")
        ->type_name("PATH.json")
        ->required();
    add_place(sub, "Where to fly a path that is round a place", [o](const Geodetic& at) { o->place = at; });
    sub.add_option("-o,--output", o->output, "A film, OUT.mp4, or a folder of pictures")->required();
    sub.add_option("--fps", o->fps, "Frames a second (default 30)")->check(CLI::Range(0.01, 1000.0));
    add_value(sub, "--size", "WxH", "Pixels (default 1280x720)",
              [o](const std::string& text) { o->size = parse_picture_size(text); });
    sub.add_option("--stats", o->stats, "Counters and times, a line a frame")->type_name("OUT.csv");
    sub.add_flag("--json", o->json, "Print the summary as JSON");
    sub.add_option("--format", o->format, "Of pictures in a folder: png (default) or exr, linear")
        ->check(CLI::IsMember({"png", "exr"}));
    add_refinement_options(sub, *o);
    add_pipeline_cache(sub, o->renderer.pipeline_cache);
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    sub.add_flag("--validation", o->renderer.validation,
                 "Fail on any message of the Vulkan validation layer");
    sub.add_flag("--overwrite", o->overwrite, "Replace existing outputs");
    add_look_options(sub, o->look);
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
