// carat fly: a flight along keyframes, every frame converged.
#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "carat/globe/error.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/flight.hpp"
#include "commands.hpp"
#include "frame_sink.hpp"
#include "look.hpp"
#include "progress.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

struct Options {
    std::string file, path, output, stats;
    std::array<int, 2> size{1280, 720};
    double fps = 30, error = 1, spacing = 1.5;
    Look look;
    RendererOptions renderer;
    bool overwrite = false;
};

constexpr const char* kFooter = R"(
Every frame is converged: a pure function of the file and the view, whatever was drawn before.

The path is JSON: a list of keyframes with "time" (seconds), "lat", "lon" (degrees), "height" (metres above the
ellipsoid), "heading", "pitch" and "fov" (degrees; default 0, -90, 45). Between them the eye follows the geodesic, faster
the higher it is, and its height changes by equal factors in equal times.

  [{"time": 0, "lat": 20, "lon": -110, "height": 9e6, "pitch": -90},
   {"time": 8, "lat": 36, "lon": -118.5, "height": 6000, "heading": 20, "pitch": -10}]

OUT.mp4 needs ffmpeg; any other output is a folder of frame-00001.png and so on. --stats has one CSV line a frame.

Examples:
  carat fly earth.carat --path descent.json --size 1280x720 -o descent.mp4
  carat fly earth.carat --path descent.json --fps 10 --stats descent.csv -o frames)";

Keyframe keyframe(const nlohmann::json& j) {
    Keyframe k;
    k.time = j.at("time").get<double>();
    k.eye = {j.at("lat").get<double>(), j.at("lon").get<double>()};
    k.height = j.at("height").get<double>();
    k.heading = j.value("heading", 0.0);
    k.pitch = j.value("pitch", -90.0);
    k.fov = j.value("fov", 45.0);
    return k;
}

std::vector<Keyframe> read_path(const std::string& file) {
    std::ifstream in(file);
    if (!in) throw Error(ErrorCode::io, file + ": cannot open");
    try {
        std::vector<Keyframe> keys;
        for (const auto& j : nlohmann::json::parse(in)) keys.push_back(keyframe(j));
        return keys;
    } catch (const nlohmann::json::exception& e) {
        throw Error(ErrorCode::corrupt, file + ": " + e.what());
    }
}

// One CSV line a frame.
class FrameTable {
  public:
    explicit FrameTable(const std::string& file) : name_(file) {
        if (name_.empty()) return;
        out_.open(name_);
        if (!out_) throw Error(ErrorCode::io, name_ + ": cannot create");
        out_ << "frame,time_s,lat,lon,height_m,patches,triangles,refined,decoded,virtual,worst_error_px,"
                "pages,bytes,"
                "uploaded,selection_ms,decode_ms,build_ms,upload_ms,gpu_ms,total_ms\n";
    }
    void add(int frame, double time, const ViewRequest& v, const CutCounters& c, const FrameCounters& f,
             double total) {
        if (name_.empty()) return;
        out_ << fmt::format(
            "{},{:.4f},{:.7f},{:.7f},{:.3f},{},{},{},{},{},{:.4f},{},{},{},{:.2f},{:.2f},{:.2f},{:.2f},"
            "{:.2f},{:.2f}\n",
            frame, time, v.eye.latitude, v.eye.longitude, v.height, c.patches, c.triangles, c.refined,
            c.decoded, c.virtual_refined, c.worst_error, c.read.pages, c.read.bytes, f.patches_uploaded,
            c.selection_ms, c.decode_ms, c.build_ms, f.upload_ms, f.gpu_ms, total);
        if (!out_) throw Error(ErrorCode::io, name_ + ": cannot write");
    }

  private:
    std::string name_;
    std::ofstream out_;
};

int run(const Options& o, const Globals& globals) {
    using Clock = std::chrono::steady_clock;
    const auto begin = Clock::now();
    const auto file = Repository::open(o.file);
    const Ellipsoid body = file->header().ellipsoid();
    const Flight flight(body, read_path(o.path));
    FrameSink sink(o.output, o.fps, o.overwrite);
    FrameTable table(o.stats);
    RendererOptions options = o.renderer;
    options.cells = file->header().cells();
    std::unique_ptr<Renderer> renderer;

    const int frames = static_cast<int>(std::floor(flight.duration() * o.fps)) + 1;
    Progress progress("frames", globals.quiet);
    for (int k = 0; k < frames; ++k) {
        const auto started = Clock::now();
        const double time = k / o.fps;
        ViewRequest where = flight.at(time);
        where.width = o.size[0];
        where.image_height = o.size[1];
        const View view(body, where);
        if (!renderer) renderer = std::make_unique<Renderer>(body, view.unit(), options);
        const DrawList list = converged_cut(*file, view, o.error, o.spacing);
        const Frame frame = renderer->draw(draw_request(o.look, where, view, body), list.meshes);
        sink.add(frame.colour);
        const double total = std::chrono::duration<double, std::milli>(Clock::now() - started).count();
        table.add(k + 1, time, where, list.counters, frame.counters, total);
        if (!progress.update("flying", static_cast<std::uint64_t>(k) + 1, static_cast<std::uint64_t>(frames)))
            return kInterrupted;
    }
    progress.finish();
    sink.finish();
    for (const std::string& message : renderer->messages()) throw Error(ErrorCode::io, "Vulkan: " + message);
    if (!globals.quiet) {
        const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
        fmt::print(stderr, "{}: {} frames, {:.2f} s each on {}\n", o.output, frames, seconds / frames,
                   renderer->device_name());
    }
    return kSuccess;
}

}  // namespace

void add_fly(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("fly", "Draw a flight over the planet");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    sub.add_option("--path", o->path, "Keyframes")->type_name("PATH.json")->required();
    sub.add_option("-o,--output", o->output, "A film, OUT.mp4, or a folder of pictures")->required();
    sub.add_option("--fps", o->fps, "Frames a second (default 30)")->check(CLI::Range(0.01, 1000.0));
    add_value(sub, "--size", "WxH", "Pixels (default 1280x720)",
              [o](const std::string& text) { o->size = parse_picture_size(text); });
    sub.add_option("--error", o->error, "Greatest error on the screen, pixels (default 1)")
        ->check(CLI::PositiveNumber);
    sub.add_option("--spacing", o->spacing,
                   "Greatest distance of samples on the screen, pixels, where the file has finer "
                   "ones; 0: --error alone decides (default 1.5)")
        ->check(CLI::NonNegativeNumber);
    sub.add_option("--stats", o->stats, "Counters and times, a line a frame")->type_name("OUT.csv");
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    sub.add_flag("--validation", o->renderer.validation,
                 "Fail on any message of the Vulkan validation layer");
    sub.add_flag("--overwrite", o->overwrite, "Replace existing outputs");
    add_look_options(sub, o->look);
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
