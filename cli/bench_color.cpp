// carat bench color: 8-bit RGB through YCoCg-R against JPEG XL.
#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/color_bench.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string image;
    std::optional<bench::Crop> crop;
    bench::ColorOptions bench;
    bool json = false;
};

constexpr const char* kFooter = R"(
Carat's codec in modes 0, 1 and 2 on the components Y, Co, Cg of the reversible transform YCoCg-R, with component
tolerances that keep every RGB channel within the tolerance; JPEG XL lossy at the greatest distance whose measured
error keeps it; JPEG XL lossless on quantised channels. Errors are measured after decoding.

Example:
  carat bench color bluemarble.jpg --tolerance 10)";

void print_text(const Options& o, const std::vector<bench::ColorRow>& rows) {
    fmt::print("{}\n{:<16} {:<28} {:>10} {:>8} {:>8} {:>9} {:>9}\n", o.image, "codec", "setting",
               "bits/pixel", "max err", "rms err", "enc MP/s", "dec MP/s");
    for (const bench::ColorRow& r : rows)
        fmt::print("{:<16} {:<28} {:>10.4f} {:>8} {:>8.3f} {:>9.2f} {:>9.2f}{}\n", r.codec, r.setting,
                   r.bits_per_pixel, r.max_error, r.rms_error, r.encode_rate / 1e6, r.decode_rate / 1e6,
                   r.max_error > o.bench.tolerance ? "  ABOVE THE TOLERANCE" : "");
}

void print_json(const Options& o, const std::vector<bench::ColorRow>& rows) {
    Json list = Json::array();
    for (const bench::ColorRow& r : rows)
        list.push_back({{"codec", r.codec},
                        {"setting", r.setting},
                        {"bytes", r.bytes},
                        {"bits_per_pixel", r.bits_per_pixel},
                        {"max_error", r.max_error},
                        {"rms_error", r.rms_error},
                        {"encode_pixels_per_second", r.encode_rate},
                        {"decode_pixels_per_second", r.decode_rate}});
    fmt::print("{}\n", Json({{"image", o.image}, {"tolerance", o.bench.tolerance}, {"rows", list}}).dump(2));
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    Progress progress("measurements", globals.quiet);
    bench::ColorOptions options = o.bench;
    options.progress = [&](const std::string& what, std::size_t done, std::size_t total) {
        return progress.update(what, done, total);
    };
    const std::vector<bench::ColorRow> rows = bench::bench_color(bench::read_rgb(o.image, o.crop), options);
    progress.finish();
    if (o.json)
        print_json(o, rows);
    else
        print_text(o, rows);
    for (const bench::ColorRow& r : rows)
        if (r.max_error > o.bench.tolerance) return kFailure;
    return kSuccess;
}

}  // namespace

void add_bench_color(CLI::App& bench_app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *bench_app.add_subcommand("color", "8-bit RGB against JPEG XL at equal greatest error");
    sub.footer(kFooter);
    sub.add_option("IMAGE", o->image, "An image of three 8-bit bands, any format GDAL reads")
        ->required()
        ->type_name(" ");
    add_crop(sub, o->crop);
    sub.add_option("--tolerance", o->bench.tolerance, "Greatest error of a channel, of 255 (default 10)")
        ->check(between(0, 127));
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
