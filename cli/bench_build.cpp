// carat bench build: time, memory and bytes of builds, beside a peer that makes a cloud-optimised GeoTIFF.
#include <fmt/core.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "child_process.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "scratch_folder.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;
namespace fs = std::filesystem;

struct Options {
    std::vector<std::string> rasters;  // a layer each: names separated by commas
    double tolerance = 1;
    int rounds = 5, threads = 2;
    std::string memory, temp, csv;
    bool measure = false, peer = true, json = false;
};

struct Run {
    ChildUsage usage;
    std::uint64_t bytes = 0;  // of the output
    Json report;              // of a build
};

// All runs of one program on one layer.
struct Series {
    std::string program, raster;
    std::vector<Run> runs;

    template <class F>
    double median(F of) const {
        std::vector<double> values;
        for (const Run& r : runs) values.push_back(of(r));
        std::sort(values.begin(), values.end());
        const std::size_t n = values.size();
        return n == 0 ? 0 : (values[(n - 1) / 2] + values[n / 2]) / 2;
    }
    double seconds() const {
        return median([](const Run& r) { return r.usage.seconds; });
    }
    double processor_seconds() const {
        return median([](const Run& r) { return r.usage.processor_seconds; });
    }
    double peak_memory() const {  // the greatest
        double most = 0;
        for (const Run& r : runs) most = std::max(most, static_cast<double>(r.usage.peak_memory_bytes));
        return most;
    }
    double samples() const { return report("source_samples"); }
    double report(const char* key) const {
        return median([&](const Run& r) { return r.report.value(key, 0.0); });
    }
    double stage(const std::string& name) const {
        return median([&](const Run& r) {
            const Json stages = r.report.value("stage_seconds", Json::object());
            return stages.value(name, 0.0);
        });
    }
    std::vector<std::string> stages() const {
        std::vector<std::string> out;
        if (!runs.empty() && runs.front().report.contains("stage_seconds"))
            for (const auto& [name, seconds] : runs.front().report["stage_seconds"].items())
                out.push_back(name);
        return out;
    }
};

class BuildBench {
  public:
    BuildBench(const Options& o, const fs::path& folder) : o_(o), folder_(folder) {
        for (const std::string& raster : o.rasters) {
            if (o.peer && parse_files(raster).size() == 1) series_.push_back({"gdal_translate", raster, {}});
            series_.push_back({"carat build", raster, {}});
        }
    }

    // Each program once. False: interrupted.
    bool round(Progress& progress, int number) {
        for (std::size_t k = 0; k < series_.size(); ++k) {
            Series& s = series_[k];
            const auto done = static_cast<std::uint64_t>(number) * series_.size() + k;
            if (!progress.update(s.program + " " + s.raster, done,
                                 static_cast<std::uint64_t>(o_.rounds) * series_.size()))
                return false;
            s.runs.push_back(s.program == "carat build" ? build(s.raster) : translate(s.raster));
        }
        return true;
    }
    const std::vector<Series>& series() const { return series_; }

  private:
    Run run(const std::vector<std::string>& arguments, const fs::path& output) const {
        Run out;
        out.usage = run_child(arguments, folder_ / "stdout", folder_ / "stderr");
        out.bytes = fs::file_size(output);
        fs::remove(output);
        return out;
    }
    Run translate(const std::string& raster) const {
        const fs::path output = folder_ / "peer.tif";
        return run({"gdal_translate", "-q", "-of", "COG", "-co", "COMPRESS=LERC_ZSTD", "-co",
                    "MAX_Z_ERROR=" + number(o_.tolerance), "-co", "NUM_THREADS=" + std::to_string(o_.threads),
                    raster, output.string()},
                   output);
    }
    Run build(const std::string& raster) const {
        const fs::path output = folder_ / "build.carat";
        std::vector<std::string> arguments{fs::read_symlink("/proc/self/exe").string(),
                                           "build",
                                           "-q",
                                           "--json",
                                           "--layer",
                                           raster,
                                           "--tolerance",
                                           number(o_.tolerance),
                                           "--threads",
                                           std::to_string(o_.threads),
                                           "-o",
                                           output.string(),
                                           o_.measure ? "--measure" : "--no-measure"};
        if (!o_.memory.empty()) arguments.insert(arguments.end(), {"--memory", o_.memory});
        Run out = run(arguments, output);
        std::ifstream report(folder_ / "stdout");
        out.report = Json::parse(report);
        return out;
    }

    const Options& o_;
    fs::path folder_;
    std::vector<Series> series_;
};

// The series that a build is compared with: the peer on the same raster.
const Series* peer_of(const std::vector<Series>& all, const Series& build) {
    for (const Series& s : all)
        if (s.program != build.program && s.raster == build.raster) return &s;
    return nullptr;
}

bool is_build(const Series& s) { return s.program == "carat build"; }

// Name and value of every column after program and raster; builds have more of them.
std::vector<std::pair<std::string, double>> values_of(const std::vector<Series>& all, const Series& s) {
    std::vector<std::pair<std::string, double>> out{
        {"seconds", s.seconds()},
        {"least_seconds",
         std::min_element(s.runs.begin(), s.runs.end(),
                          [](const Run& a, const Run& b) { return a.usage.seconds < b.usage.seconds; })
             ->usage.seconds},
        {"processor_seconds", s.processor_seconds()},
        {"peak_memory_bytes", s.peak_memory()},
        {"output_bytes", s.median([](const Run& r) { return static_cast<double>(r.bytes); })}};
    if (!is_build(s)) return out;
    out.emplace_back("source_samples", s.samples());
    out.emplace_back("samples_per_second", s.samples() / s.seconds());
    out.emplace_back("samples_per_processor_second", s.samples() / s.processor_seconds());
    out.emplace_back("temporary_peak_bytes", s.report("temporary_peak_bytes"));
    if (const Series* peer = peer_of(all, s)) {
        out.emplace_back("ratio_seconds", s.seconds() / peer->seconds());
        out.emplace_back("ratio_processor_seconds", s.processor_seconds() / peer->processor_seconds());
    }
    for (const std::string& stage : s.stages()) out.emplace_back("stage_" + stage, s.stage(stage));
    return out;
}

std::string csv_of(const std::vector<Series>& all) {
    std::vector<std::string> columns;  // of all series, in order
    std::vector<std::map<std::string, double>> rows;
    for (const Series& s : all) {
        auto& row = rows.emplace_back();
        for (const auto& [name, value] : values_of(all, s)) {
            row[name] = value;
            if (std::find(columns.begin(), columns.end(), name) == columns.end()) columns.push_back(name);
        }
    }
    std::string out = "program,raster,rounds";
    for (const std::string& c : columns) out += "," + c;
    for (std::size_t k = 0; k < all.size(); ++k) {
        out += fmt::format("\n{},\"{}\",{}", all[k].program, all[k].raster, all[k].runs.size());
        for (const std::string& c : columns) out += rows[k].contains(c) ? "," + number(rows[k].at(c)) : ",";
    }
    return out + "\n";
}

Json json_of(const std::vector<Series>& all) {
    Json out = Json::array();
    for (const Series& s : all) {
        Json row{{"program", s.program}, {"raster", s.raster}, {"rounds", s.runs.size()}};
        for (const auto& [name, value] : values_of(all, s)) row[name] = value;
        out.push_back(row);
    }
    return out;
}

// Many rasters of one layer are named by their first.
std::string short_name(const std::string& raster) {
    const std::vector<std::string> files = parse_files(raster);
    const std::string first = fs::path(files.front()).filename().string();
    return files.size() == 1 ? first : fmt::format("{} and {} more", first, files.size() - 1);
}

void print(const std::vector<Series>& all) {
    fmt::print("{:<15} {:<26} {:>8} {:>8} {:>8} {:>9} {:>9} {:>14} {:>7} {:>7}\n", "program", "raster",
               "median s", "least s", "proc. s", "MS/s", "memory", "bytes", "ratio", "proc.");
    for (const Series& s : all) {
        std::map<std::string, double> v;
        for (const auto& [name, value] : values_of(all, s)) v[name] = value;
        const auto optional = [&](const char* key, double scale) {
            return v.contains(key) ? fmt::format("{:.2f}", v[key] * scale) : "";
        };
        fmt::print("{:<15} {:<26} {:>8.2f} {:>8.2f} {:>8.2f} {:>9} {:>9} {:>14} {:>7} {:>7}\n", s.program,
                   short_name(s.raster), v["seconds"], v["least_seconds"], v["processor_seconds"],
                   optional("samples_per_second", 1e-6),
                   bytes_text(static_cast<std::uint64_t>(v["peak_memory_bytes"])),
                   grouped(static_cast<std::uint64_t>(v["output_bytes"])), optional("ratio_seconds", 1),
                   optional("ratio_processor_seconds", 1));
    }
    for (const Series& s : all) {
        if (!is_build(s)) continue;
        fmt::print("stages of {}, median s:", short_name(s.raster));
        for (const std::string& stage : s.stages()) fmt::print(" {} {:.2f}", stage, s.stage(stage));
        fmt::print("; temporary files {}\n",
                   bytes_text(static_cast<std::uint64_t>(s.report("temporary_peak_bytes"))));
    }
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    const ScratchFolder scratch("build", o.temp);
    BuildBench bench(o, scratch.path());
    Progress progress("runs", globals.quiet);
    for (int k = 0; k < o.rounds; ++k)
        if (!bench.round(progress, k)) return kInterrupted;
    progress.finish();
    if (o.json)
        fmt::print("{}\n", json_of(bench.series()).dump(2));
    else
        print(bench.series());
    write_text(o.csv, csv_of(bench.series()));
    return kSuccess;
}

constexpr const char* kFooter = R"(
Runs `carat build` on each layer, and `gdal_translate -of COG -co COMPRESS=LERC_ZSTD -co MAX_Z_ERROR=E` with overviews where the
layer is one raster, as processes of their own, in turn, and prints medians of all rounds: seconds by the wall clock and of
the processor (all threads), source samples a second, peak resident memory as the operating system tells, the bytes that came
out, the ratio to the peer, and where a build's time goes. A layer of many rasters: their names, separated by commas.

Examples:
  carat bench build california_3s.tif --csv build.csv
  carat bench build part.tif tile1.tif,tile2.tif,tile3.tif --memory 1G --no-peer --rounds 1)";

}  // namespace

void add_bench_build(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("build", "Builds beside gdal_translate: time, memory, bytes");
    sub.footer(kFooter);
    sub.add_option("FILES", o->rasters, "Layers, a build each: a raster, or FILE,FILE,...")
        ->required()
        ->type_name(" ")
        ->type_size(1)
        ->expected(-1);
    sub.add_option("--tolerance", o->tolerance, "Metres (default 1)")->check(CLI::PositiveNumber);
    sub.add_option("--rounds", o->rounds, "Runs of each program (default 5)")->check(between(1, 1000));
    sub.add_option("--threads", o->threads, "Of both programs (default 2)")->check(between(1, 1024));
    add_value(sub, "--memory", "SIZE", "Bound of builds (default: a quarter of the machine's)",
              [o](const std::string& text) {
                  (void)parse_size(text);
                  o->memory = text;
              });
    sub.add_option("--temp", o->temp, "Folder for outputs and temporary files (default: the system's)")
        ->type_name("DIR");
    sub.add_flag("--measure", o->measure, "Builds compare the result with every source sample too");
    sub.add_flag("--peer,!--no-peer", o->peer, "Run gdal_translate too (default yes)");
    sub.add_option("--csv", o->csv, "Also write the table here");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
