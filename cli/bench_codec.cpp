// carat bench codec: the codec against its peers.
#include <fmt/core.h>

#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/codec_bench.hpp"
#include "carat/bench/globe_job.hpp"
#include "carat/bench/svg.hpp"
#include "carat/globe/error.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct CodecOptions {
    std::vector<std::string> rasters;
    std::optional<bench::Crop> crop;
    bool json = false;
    std::string csv, svg;
    bool globe = false;
    Ellipsoid body = Ellipsoid::earth();
    bench::CodecBenchOptions bench;
};

// All that was measured on one raster.
struct Measured {
    std::string name;
    bench::Raster raster;
    std::size_t filled = 0;
    bench::CodecTable table;
    std::vector<bench::GlobeRow> globe;
};

bool is_ours(const bench::CodecRow& row) { return row.codec.starts_with("carat"); }

constexpr const char* kCodecFooter = R"(
Same samples for all, one thread, one run: Carat's codec on a planar diamond lattice against LERC, ZFP, JPEG XL,
OpenJPEG and ZSTD, each at the same greatest error. Integer heights and an integer tolerance E allow a quantiser
step of 2 E + 1, and 0.5 means lossless. Every residual is decoded again and compared; of Carat's planes the index
is counted as 4 bytes a diamond and the root as Elias-gamma codes, neither is written.

With --globe also whole .carat files of the globe, built from the raster on one thread: all levels of detail, on a
lattice that is not the raster's, with the index, summaries and directory of a file; their errors are measured at the
raster's own samples. The peers' files of the raster stand below them, bits a valid source sample for all.

Examples:
  carat bench codec california.tif --crop 4000,400,4097,4097
  carat bench codec california.tif --codecs carat,lerc --tolerance 1,16 --csv table.csv --svg plot.svg
  carat bench codec mars.tif --globe --body mars)";

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

void print_rows(const Measured& m) {
    const bench::CodecTable& t = m.table;
    fmt::print(
        "{}: {} x {} {} samples, {} missing ones filled; memory copy {:.2f} bytes/cycle at {:.2f} GHz\n",
        m.name, m.raster.width, m.raster.height, m.raster.integer ? "int16" : "float32", grouped(m.filled),
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

Json globe_json(const bench::GlobeRow& r) {
    return {{"coder", r.coder},
            {"tolerance", r.tolerance},
            {"file_bytes", r.file_bytes},
            {"source_samples", r.source_samples},
            {"leaf_samples", r.leaf_samples},
            {"bits_per_source_sample", r.bits_per_source_sample},
            {"refined_diamonds", r.diamonds},
            {"index_bytes", r.index_bytes},
            {"max_error_lattice", r.at_lattice.max},
            {"rms_error_lattice", r.at_lattice.rms},
            {"max_error_source", r.at_source.max},
            {"p99_error_source", r.p99_at_source},
            {"rms_error_source", r.at_source.rms},
            {"build_seconds", r.build_seconds}};
}

Json json_of(const Measured& m) {
    Json rows = Json::array(), globe = Json::array();
    for (const bench::CodecRow& r : m.table.rows) rows.push_back(row_json(r));
    for (const bench::GlobeRow& r : m.globe) globe.push_back(globe_json(r));
    return {{"raster", m.name},
            {"width", m.raster.width},
            {"height", m.raster.height},
            {"samples", m.raster.integer ? "int16" : "float32"},
            {"filled", m.filled},
            {"copy_bytes_per_cycle", m.table.copy_bytes_per_cycle},
            {"cycles_per_second", m.table.cycles_per_second},
            {"rows", rows},
            {"globe", globe}};
}

void print_globe(const Measured& m) {
    if (m.globe.empty()) return;
    fmt::print(
        "the same job: whole .carat files of the globe, index and summaries as bytes a diamond; errors at "
        "source samples\n");
    fmt::print("{:<14} {:>9} {:>12} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}\n", "coder", "tolerance",
               "bytes", "bits/smp", "leaf/src", "index B", "lat. max", "max err", "p99 err", "rms err",
               "build s");
    for (const bench::GlobeRow& r : m.globe)
        fmt::print(
            "{:<14} {:>9} {:>12} {:>9.4f} {:>9.2f} {:>9.1f} {:>9.4f} {:>9.3f} {:>9.3f} {:>9.4f} {:>9.1f}\n",
            "globe " + r.coder, r.tolerance, grouped(r.file_bytes), r.bits_per_source_sample,
            static_cast<double>(r.leaf_samples) / static_cast<double>(r.source_samples),
            static_cast<double>(r.index_bytes) / static_cast<double>(std::max<std::uint64_t>(1, r.diamonds)),
            r.at_lattice.max, r.at_source.max, r.p99_at_source, r.at_source.rms, r.build_seconds);
    const auto samples = static_cast<double>(std::max<std::uint64_t>(1, m.globe.front().source_samples));
    for (const bench::CodecRow& r : m.table.rows)
        if (r.failure.empty() && !is_ours(r))
            fmt::print("{:<14} {:>9} {:>12} {:>9.4f} {:>9} {:>9} {:>9} {:>9.3f} {:>9} {:>9.4f}\n",
                       r.codec + " " + r.unit, r.tolerance, grouped(r.bytes),
                       8 * static_cast<double>(r.bytes) / samples, "1", "", "", r.errors.max, "",
                       r.errors.rms);
}

// Size against tolerance, and decoding rate against size; whole rasters only.
std::vector<bench::Plot> plots(const Measured& m) {
    std::vector<bench::Plot> out = {{m.name, "greatest error, m", "bits a sample", {}},
                                    {"", "bits a sample", "decoding, million samples/s", {}}};
    for (const bench::CodecRow& r : m.table.rows) {
        if (!r.failure.empty() || r.unit == std::to_string(256)) continue;
        for (bench::Plot& p : out)
            if (p.series.empty() || p.series.back().name != r.codec)
                p.series.push_back({r.codec, {}, {}, is_ours(r)});
        out[0].series.back().x.push_back(r.tolerance);
        out[0].series.back().y.push_back(r.bits_per_sample);
        out[1].series.back().x.push_back(r.bits_per_sample);
        out[1].series.back().y.push_back(r.decode_rate / 1e6);
    }
    return out;
}

void write_file(const std::string& name, const std::string& text) {
    std::ofstream out(name, std::ios::binary);
    out << text;
    if (!out.flush()) throw Error(ErrorCode::io, name + ": cannot be written");
}

std::vector<bench::GlobeRow> measure_globe(const std::string& file, const CodecOptions& o,
                                           Progress& progress) {
    std::vector<bench::GlobeRow> rows;
    for (const std::string& coder : bench::globe_coders())
        for (const double tolerance : o.bench.tolerances)
            rows.push_back(
                bench::bench_globe(file, o.crop, o.body, coder, tolerance, [&](const BuildProgress& p) {
                    return progress.update(
                        fmt::format("globe {} {}: {}", coder, tolerance, to_string(p.stage)), p.done,
                        p.total);
                }));
    return rows;
}

Measured measure(const std::string& file, const CodecOptions& o, const Globals& globals) {
    Measured m;
    m.name = std::filesystem::path(file).filename().string();
    m.raster = bench::read_raster(file, o.crop, m.filled);
    Progress progress("measurements", globals.quiet);
    bench::CodecBenchOptions options = o.bench;
    options.progress = [&](const std::string& what, std::size_t done, std::size_t total) {
        return progress.update(what, done, total);
    };
    m.table = bench::bench_codecs(m.raster, options);
    if (o.globe) m.globe = measure_globe(file, o, progress);
    progress.finish();
    return m;
}

int run_codec(const CodecOptions& o, const Globals& globals) {
    catch_interrupts();
    Json all = Json::array();
    std::string csv;
    std::vector<bench::Plot> pictures;
    bool within = true;
    for (const std::string& file : o.rasters) {
        const Measured m = measure(file, o, globals);
        for (const bench::CodecRow& r : m.table.rows)
            within = within && (r.within || (!r.failure.empty() && !is_ours(r)));
        if (o.json) {
            all.push_back(json_of(m));
        } else {
            print_rows(m);
            print_globe(m);
        }
        add_csv(csv, m.name, m.table);
        for (bench::Plot& p : plots(m)) pictures.push_back(std::move(p));
    }
    if (o.json) fmt::print("{}\n", all.dump(2));
    if (!o.csv.empty()) write_file(o.csv, csv);
    if (!o.svg.empty()) write_file(o.svg, bench::svg_of(pictures));
    return within ? kSuccess : kFailure;
}

}  // namespace

void add_bench_codec(CLI::App& bench_app, Globals& globals) {
    const auto o = std::make_shared<CodecOptions>();
    CLI::App& sub = *bench_app.add_subcommand("codec", "Carat's codec against its peers on the same samples");
    sub.footer(kCodecFooter);
    sub.add_option("RASTER", o->rasters, "Elevation rasters, any format GDAL reads")
        ->required()
        ->type_name(" ");
    add_crop(sub, o->crop);
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
    sub.add_flag("--globe", o->globe, "Also build whole .carat files; the rasters must be georeferenced");
    add_value(sub, "--body", "BODY", "For --globe: earth (default), moon, mars or semi-axes A,B in metres",
              [o](const std::string& text) { o->body = Ellipsoid::parse(text); });
    sub.add_option("--csv", o->csv, "Also write the table here");
    sub.add_option("--svg", o->svg, "Also plot size against error, and speed against size, here");
    on_run(sub, globals, [o, &globals] { return run_codec(*o, globals); });
}

}  // namespace carat::cli
