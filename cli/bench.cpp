// carat bench: tables of size, error and speed.
#include <fmt/core.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "commands.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

#ifdef CARAT_HAS_BENCH
#include "carat/bench/codec_bench.hpp"
#endif
#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

#ifdef CARAT_HAS_BENCH
using Json = nlohmann::ordered_json;

struct CodecOptions {
    std::vector<std::string> rasters;
    std::optional<bench::Crop> crop;
    bool json = false;
    std::string csv;
    bench::CodecBenchOptions bench;
};

constexpr const char* kCodecFooter = R"(
Same samples for all, one thread, one run: Carat's codec on a planar diamond lattice against LERC, ZFP, JPEG XL,
OpenJPEG and ZSTD, each at the same greatest error. Integer heights and an integer tolerance E allow a quantiser
step of 2 E + 1, and 0.5 means lossless. Every size is of data that were decoded again and compared.

Examples:
  carat bench codec california.tif --crop 4000,400,4097,4097
  carat bench codec california.tif --codecs carat,lerc --tolerance 1,16 --csv table.csv)";

Json row_json(const bench::CodecRow& r) {
    if (!r.failure.empty())
        return {{"codec", r.codec}, {"unit", r.unit}, {"tolerance", r.tolerance}, {"failure", r.failure}};
    return {{"codec", r.codec},
            {"unit", r.unit},
            {"tolerance", r.tolerance},
            {"bytes", r.bytes},
            {"bits_per_sample", r.bits_per_sample},
            {"max_error", r.errors.max},
            {"rms_error", r.errors.rms},
            {"within", r.within},
            {"encode_samples_per_second", r.encode_rate},
            {"decode_samples_per_second", r.decode_rate},
            {"decode_cycles_per_sample", r.decode_cycles},
            {"decode_bytes_per_cycle", r.decode_bytes_per_cycle},
            {"decode_shares", r.decode_shares}};
}

void print_rows(const std::string& name, const bench::Raster& raster, std::size_t filled,
                const bench::CodecTable& t) {
    fmt::print(
        "{}: {} x {} {} samples, {} missing ones filled; memory copy {:.2f} bytes/cycle at {:.2f} GHz\n",
        name, raster.width, raster.height, raster.integer ? "int16" : "float32", grouped(filled),
        t.copy_bytes_per_cycle, t.cycles_per_second / 1e9);
    fmt::print("{:<12} {:<9} {:>9} {:>8} {:>9} {:>8} {:>9} {:>9} {:>8} {:>7}  {}\n", "codec", "unit",
               "tolerance", "bits/smp", "max err", "rms err", "enc MS/s", "dec MS/s", "cyc/smp", "B/cyc",
               "gather/kernel/store");
    for (const bench::CodecRow& r : t.rows) {
        if (!r.failure.empty()) {
            fmt::print("{:<12} {:<9} {:>9} {}\n", r.codec, r.unit, r.tolerance, r.failure);
            continue;
        }
        std::string shares;
        for (const double s : r.decode_shares)
            shares += fmt::format("{}{:.0f}", shares.empty() ? "" : "/", 100 * s);
        fmt::print(
            "{:<12} {:<9} {:>9} {:>8.4f} {:>9.4f} {:>8.4f} {:>9.1f} {:>9.1f} {:>8.2f} {:>7.3f}  {}{}\n",
            r.codec, r.unit, r.tolerance, r.bits_per_sample, r.errors.max, r.errors.rms, r.encode_rate / 1e6,
            r.decode_rate / 1e6, r.decode_cycles, r.decode_bytes_per_cycle, shares,
            r.within ? "" : "  ABOVE THE TOLERANCE");
    }
}

void add_csv(std::string& csv, const std::string& name, const bench::CodecTable& t) {
    if (csv.empty())
        csv =
            "raster,codec,unit,tolerance,bytes,bits_per_sample,max_error,rms_error,encode_MSps,decode_MSps,"
            "decode_cycles_per_sample,decode_bytes_per_cycle,copy_bytes_per_cycle\n";
    for (const bench::CodecRow& r : t.rows)
        if (r.failure.empty())
            csv += fmt::format("{},{},{},{},{},{:.5f},{:.6g},{:.6g},{:.2f},{:.2f},{:.3f},{:.4f},{:.4f}\n",
                               name, r.codec, r.unit, r.tolerance, r.bytes, r.bits_per_sample, r.errors.max,
                               r.errors.rms, r.encode_rate / 1e6, r.decode_rate / 1e6, r.decode_cycles,
                               r.decode_bytes_per_cycle, t.copy_bytes_per_cycle);
}

int run_codec(const CodecOptions& o, const Globals& globals) {
    catch_interrupts();
    Json all = Json::array();
    std::string csv;
    bool within = true;
    for (const std::string& file : o.rasters) {
        std::size_t filled = 0;
        const bench::Raster raster = bench::read_raster(file, o.crop, filled);
        Progress progress("measurements", globals.quiet);
        bench::CodecBenchOptions options = o.bench;
        options.progress = [&](const std::string& what, std::size_t done, std::size_t total) {
            return progress.update(what, done, total);
        };
        const bench::CodecTable table = bench::bench_codecs(raster, options);
        progress.finish();
        for (const bench::CodecRow& r : table.rows) within = within && (r.within || !r.failure.empty());
        if (o.json) {
            Json rows = Json::array();
            for (const bench::CodecRow& r : table.rows) rows.push_back(row_json(r));
            all.push_back({{"raster", file},
                           {"width", raster.width},
                           {"height", raster.height},
                           {"samples", raster.integer ? "int16" : "float32"},
                           {"filled", filled},
                           {"copy_bytes_per_cycle", table.copy_bytes_per_cycle},
                           {"cycles_per_second", table.cycles_per_second},
                           {"rows", rows}});
        } else {
            print_rows(file, raster, filled, table);
        }
        add_csv(csv, file, table);
    }
    if (o.json) fmt::print("{}\n", all.dump(2));
    if (!o.csv.empty()) {
        std::ofstream out(o.csv, std::ios::binary);
        out << csv;
        if (!out.flush()) throw Error(ErrorCode::io, o.csv + ": cannot be written");
    }
    return within ? kSuccess : kFailure;
}

void add_codec(CLI::App& bench_app, Globals& globals) {
    const auto o = std::make_shared<CodecOptions>();
    CLI::App& sub = *bench_app.add_subcommand("codec", "Carat's codec against its peers on the same samples");
    sub.footer(kCodecFooter);
    sub.add_option("RASTER", o->rasters, "Elevation rasters, any format GDAL reads")
        ->required()
        ->type_name(" ");
    add_value(sub, "--crop", "X,Y,W,H", "Part of each raster, pixels", [o](const std::string& text) {
        const std::vector<double> v = parse_numbers(text, 4);
        o->crop = bench::Crop{static_cast<int>(v[0]), static_cast<int>(v[1]), static_cast<int>(v[2]),
                              static_cast<int>(v[3])};
    });
    sub.add_option("--tolerance", o->bench.tolerances, "Greatest errors, metres (default 0.5,1,4,16)")
        ->delimiter(',')
        ->check(between(1e-6, 1e6));
    sub.add_option("--codecs", o->bench.codecs,
                   "Only these, by name or its beginning (carat,lerc,zfp,jxl,...)")
        ->delimiter(',');
    sub.add_option("--tile", o->bench.tile, "Samples a side of tiles; 0: no tiles (default 256)")
        ->check(between(0, 65536));
    sub.add_option("--repeats", o->bench.repeats, "Timings are the median of so many (default 3)")
        ->check(between(1, 1000));
    sub.add_flag("--json", o->json, "Print JSON");
    sub.add_option("--csv", o->csv, "Also write the table here");
    on_run(sub, globals, [o, &globals] { return run_codec(*o, globals); });
}
#endif

}  // namespace

void add_bench(CLI::App& app, Globals& globals) {
    CLI::App& sub = *app.add_subcommand("bench", "Measure size, error and speed");
#ifdef CARAT_HAS_BENCH
    sub.require_subcommand(1);
    add_codec(sub, globals);
#else
    sub.allow_extras();
    on_run(sub, globals, []() -> int {
        throw Error(ErrorCode::unsupported,
                    "this program was built without its benchmarks (CARAT_BUILD_BENCH)");
    });
#endif
}

}  // namespace carat::cli
