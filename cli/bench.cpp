// carat bench: tables of size, error and speed.
#include "carat/globe/error.hpp"
#include "commands.hpp"

#ifdef CARAT_HAS_BENCH
#include <fmt/format.h>

#include <cmath>
#include <fstream>

#include "bench.hpp"
#include "values.hpp"
#endif

namespace carat::cli {

#ifdef CARAT_HAS_BENCH
void write_text(const std::string& file, const std::string& text) {
    if (file.empty()) return;
    std::ofstream out(file, std::ios::binary);
    out << text;
    if (!out.flush()) throw Error(ErrorCode::io, file + ": cannot be written");
}

void add_bench_direction(CLI::App& sub, ViewRequest& view) {
    const auto angle = [&](const char* name, double& out, const char* description) {
        add_value(sub, name, "DEG", fmt::format("{} (default {})", description, out),
                  [&out](const std::string& text) { out = parse_number(text); });
    };
    angle("--heading", view.heading, "Clockwise from north");
    angle("--pitch", view.pitch, "Up from the horizon");
    add_value(sub, "--size", "WxH", fmt::format("Pixels (default {}x{})", view.width, view.image_height),
              [&view](const std::string& text) {
                  const auto size = parse_picture_size(text);
                  view.width = size[0];
                  view.image_height = size[1];
              });
}

void add_crop(CLI::App& sub, std::optional<bench::Crop>& crop) {
    add_value(sub, "--crop", "X,Y,W,H", "Part of each raster, pixels", [&crop](const std::string& text) {
        const std::vector<double> v = parse_numbers(text, 4);
        const auto pixels = [](double x) {
            if (x != std::floor(x) || std::abs(x) > 1e9)
                throw CLI::ValidationError("pixels are whole numbers");
            return static_cast<int>(x);
        };
        crop = bench::Crop{pixels(v[0]), pixels(v[1]), pixels(v[2]), pixels(v[3])};
    });
}
#endif

void add_bench(CLI::App& app, Globals& globals) {
    CLI::App& sub = *app.add_subcommand("bench", "Measure size, error and speed");
#ifdef CARAT_HAS_BENCH
    sub.require_subcommand(1);
    add_bench_codec(sub, globals);
    add_bench_build(sub, globals);
    add_bench_color(sub, globals);
    add_bench_summaries(sub, globals);
    add_bench_refine(sub, globals);
    add_bench_deadline(sub, globals);
    add_bench_scaling(sub, globals);
    add_bench_stability(sub, globals);
    add_bench_look(sub, globals);
    add_bench_shimmer(sub, globals);
    add_bench_detail(sub, globals);
    add_bench_watertight(sub, globals);
    add_bench_error(sub, globals);
    add_bench_triangles(sub, globals);
    add_bench_threshold(sub, globals);
    add_bench_frames(sub, globals);
#else
    sub.allow_extras();
    on_run(sub, globals, []() -> int {
        throw Error(ErrorCode::unsupported,
                    "this program was built without its benchmarks (CARAT_BUILD_BENCH)");
    });
#endif
}

}  // namespace carat::cli
