// carat bench shimmer: how much a moving picture flickers, against one of 16 samples a pixel.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "bench.hpp"
#include "carat/globe/error.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/vulkan/renderer.hpp"
#include "interrupt.hpp"
#include "look.hpp"
#include "progress.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::vector<std::string> files;
    std::array<double, 3> from{36.4, -118.0, 5500}, to{36.401, -118.004, 5490};
    ViewRequest view;
    RendererOptions renderer;
    int frames = 24;
    bool json = false;
};

constexpr const char* kFooter = R"(
Flies a straight way of --frames pictures through each file, once for each remedy, and once with 4 x 4 pixels for one,
refined for these and averaged in linear light: the reference. What flickers is the difference from frame to frame that the
reference has not: (I(t+1) - I(t)) - (R(t+1) - R(t)), in 255ths of sRGB over all channels, as RMS and 99th
percentile; beside it the RMS difference from the reference in a frame, and the device's time for one. Files that differ in
--mode alone show what filtering does.

Example:
  carat bench shimmer mode0.carat mode1.carat mode2.carat --from 36.4,-118,5500 --to 36.401,-118.004,5490)";

// Samples of the device for a pixel's coverage; pixels either way that are averaged; bounds in final pixels.
struct Remedy {
    const char* name;
    int samples, scale;
    double error, spacing;
};
constexpr std::array kRemedies{
    Remedy{"none", 1, 1, 1, 1.5},
    Remedy{"half the error", 1, 1, 0.5, 0.75},
    Remedy{"4 samples", 4, 1, 1, 1.5},
    Remedy{"2 x 2 pixels", 1, 2, 1, 1.5},
    Remedy{"2 x 2, 4 samples", 4, 2, 1, 1.5},
};
constexpr Remedy kTruth{"reference", 1, 4, 0.25, 0.375};

using Image = std::vector<float>;  // R, G, B in 255ths of sRGB

Image encoded(const Picture& colour) {
    Image out;
    for (int y = 0; y < colour.height; ++y)
        for (int x = 0; x < colour.width; ++x)
            for (int channel = 0; channel < 3; ++channel)
                out.push_back(255 * srgb_encode(colour.at(x, y)[channel]));
    return out;
}

struct Film {
    std::vector<Image> frames;
    double device_ms = 0;  // a frame, mean
};

// One file, drawn by one renderer.
class Scene {
  public:
    Scene(const std::string& path, const Options& o)
        : options_(o),
          file_(Repository::open(path)),
          body_(file_->header().ellipsoid()),
          renderer_(body_, length_unit(body_), renderer_options(o, *file_)) {
        const ViewRequest first = at(0);
        light_ = draw_request(Look{}, first, View(body_, first), body_).light;
    }
    const std::string& device_name() const { return renderer_.device_name(); }

    // Nothing if the user interrupts.
    std::optional<Film> shoot(const Remedy& remedy, Progress& progress) {
        Film film;
        for (int k = 0; k < options_.frames; ++k) {
            ViewRequest where = at(static_cast<double>(k) / options_.frames);
            Look look;
            look.samples = remedy.samples;
            look.supersample = remedy.scale;
            where = drawn_view(look, where);
            const View view(body_, where);
            DrawRequest request = draw_request(look, where, view, body_);
            request.light = light_;
            const DrawList list =
                converged_cut(*file_, view, remedy.error * remedy.scale, remedy.spacing * remedy.scale);
            const Frame frame = renderer_.draw(request, list.meshes);
            film.device_ms += frame.counters.gpu_ms / options_.frames;
            film.frames.push_back(encoded(shrunk(frame.colour, remedy.scale)));
            if (!progress.update(remedy.name, static_cast<std::uint64_t>(k) + 1,
                                 static_cast<std::uint64_t>(options_.frames)))
                return std::nullopt;
        }
        return film;
    }

  private:
    // A share of the way, which is short.
    ViewRequest at(double share) const {
        const auto along = [&](std::size_t k) { return std::lerp(options_.from[k], options_.to[k], share); };
        ViewRequest view = options_.view;
        view.eye = {along(0), along(1)};
        view.height = along(2);
        return view;
    }

    static RendererOptions renderer_options(const Options& o, const Repository& file) {
        RendererOptions r = o.renderer;
        r.cells = file.header().cells();
        return r;
    }

    const Options& options_;
    std::shared_ptr<const Repository> file_;
    Ellipsoid body_;
    Renderer renderer_;
    Light light_;
};

struct Shimmer {
    double flicker_rms = 0, flicker_p99 = 0, error_rms = 0;  // 255ths
};

double root_mean_square(const std::vector<float>& x) {
    const double sum =
        std::accumulate(x.begin(), x.end(), 0.0, [](double s, float v) { return s + double{v} * v; });
    return std::sqrt(sum / static_cast<double>(x.size()));
}

Shimmer compare(const std::vector<Image>& film, const std::vector<Image>& truth) {
    std::vector<float> flicker, error;
    for (std::size_t t = 0; t < film.size(); ++t)
        for (std::size_t k = 0; k < film[t].size(); ++k) {
            error.push_back(film[t][k] - truth[t][k]);
            if (t == 0) continue;
            flicker.push_back(std::abs((film[t][k] - film[t - 1][k]) - (truth[t][k] - truth[t - 1][k])));
        }
    Shimmer s{root_mean_square(flicker), 0, root_mean_square(error)};
    const auto place = flicker.begin() + static_cast<std::ptrdiff_t>(flicker.size() * 99 / 100);
    std::nth_element(flicker.begin(), place, flicker.end());
    s.flicker_p99 = *place;
    return s;
}

// What moves in the reference itself.
double motion(const std::vector<Image>& truth) {
    std::vector<float> change;
    for (std::size_t t = 1; t < truth.size(); ++t)
        for (std::size_t k = 0; k < truth[t].size(); ++k) change.push_back(truth[t][k] - truth[t - 1][k]);
    return root_mean_square(change);
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    Progress progress("frames", globals.quiet);
    Json json = Json::array();
    for (const std::string& path : o.files) {
        Scene scene(path, o);
        const auto truth = scene.shoot(kTruth, progress);
        if (!truth) return kInterrupted;
        Json rows = Json::array();
        for (const Remedy& remedy : kRemedies) {
            const auto film = scene.shoot(remedy, progress);
            if (!film) return kInterrupted;
            const Shimmer s = compare(film->frames, truth->frames);
            rows.push_back({{"remedy", remedy.name},
                            {"flicker_rms", s.flicker_rms},
                            {"flicker_p99", s.flicker_p99},
                            {"error_rms", s.error_rms},
                            {"device_ms", film->device_ms}});
        }
        progress.finish();
        json.push_back({{"file", path},
                        {"device", scene.device_name()},
                        {"frames", o.frames},
                        {"width", o.view.width},
                        {"height", o.view.image_height},
                        {"reference_motion_rms", motion(truth->frames)},
                        {"remedies", rows}});
        if (o.json) continue;
        fmt::print(
            "{}: {} frames of {}x{}, {}; the reference moves by {:.2f} RMS\n{:<18} {:>11} {:>9} {:>10} "
            "{:>7}\n",
            path, o.frames, o.view.width, o.view.image_height, scene.device_name(), motion(truth->frames), "",
            "flicker RMS", "99 %", "error RMS", "ms");
        for (const Json& row : rows)
            fmt::print("{:<18} {:>11.3f} {:>9.2f} {:>10.3f} {:>7.1f}\n", row["remedy"].get<std::string>(),
                       row["flicker_rms"].get<double>(), row["flicker_p99"].get<double>(),
                       row["error_rms"].get<double>(), row["device_ms"].get<double>());
    }
    if (o.json) fmt::print("{}\n", json.dump(2));
    return kSuccess;
}

}  // namespace

void add_bench_shimmer(CLI::App& bench, Globals& globals) {
    const auto o = std::make_shared<Options>();
    o->view.heading = 280;
    o->view.pitch = -12;
    o->view.width = 480;
    o->view.image_height = 270;
    CLI::App& sub = *bench.add_subcommand("shimmer", "How much a moving picture flickers, by remedy");
    sub.footer(kFooter);
    sub.add_option("FILE", o->files, ".carat files")->required();
    add_numbers(sub, "--from", o->from, "LAT,LON,HEIGHT_M", "Begin of the way (default 36.4,-118,5500)");
    add_numbers(sub, "--to", o->to, "LAT,LON,HEIGHT_M", "Its end (default 36.401,-118.004,5490)");
    add_bench_direction(sub, o->view);
    sub.add_option("--frames", o->frames, "Pictures (default 24)")->check(CLI::Range(2, 1000));
    sub.add_option("--device", o->renderer.device, "Vulkan device: part of its name, or its number");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
