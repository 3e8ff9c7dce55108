// carat update: a layer more in a .carat file.
#include "carat/preprocess/update.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <memory>

#include "carat/globe/error.hpp"
#include "commands.hpp"
#include "error_report.hpp"
#include "interrupt.hpp"
#include "layer_arguments.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    LayerArguments layers;
    UpdateOptions update;
    std::string file, output;
    std::vector<std::string> sources;
    bool json = false, json_progress = false;
};

constexpr const char* kFooter = R"(
Puts a layer into a file, byte for byte as if the file had been built anew with it: new data, better data, a region more.
--at says where in the order of priority, 1 above all others (default), 2 below the first, and so on.

Only what changes is worked out: the diamonds where the new layer has data, those whose depth changes, and those that a
change above them reaches. All others are copied, as whole pages where possible. The old sources are needed, the same
files as before: they are looked for by name in the folders of --sources, beside the file, and in the current folder,
and compared with the sizes and checksums that the file records, which takes reading them once; --trust-sources compares
sizes alone, for sources that are known not to have changed. Files of modes 1 and 2 are built anew as a whole; files
built with --rms are refused, for their step hangs on all of the data.

Errors at source samples that the old file records are no longer true of the new one; --measure measures them again, which takes
as long as reading all sources. A file that was built with --certify is certified again.

The file is replaced when its successor is complete; until then, and on any failure, it stays as it was.

Examples:
  carat update earth.carat --layer city_0p5m.tif
  carat update earth.carat --layer lidar.tif --nodata -9999 --sources /data/dem --at 2 -o earth2.carat)";

Json to_json(const UpdateReport& r, const std::string& output) {
    Json stages = Json::object();
    for (const auto& [stage, seconds] : r.stage_seconds) stages[to_string(stage)] = seconds;
    Json json{{"output", output},
              {"built_anew", r.full},
              {"refined_diamonds", r.plan.refined},
              {"added_diamonds", r.added},
              {"removed_diamonds", r.removed},
              {"closure_diamonds", r.recoded},
              {"changed_diamonds", r.changed},
              {"copied_diamonds", r.copied},
              {"new_summaries", r.summaries},
              {"file_bytes", r.file_bytes},
              {"source_tiles", r.source_tiles},
              {"tile_reads", r.tile_reads},
              {"peak_memory_bytes", r.peak_memory_bytes},
              {"warnings", r.plan.warnings},
              {"seconds", r.seconds},
              {"stage_seconds", stages}};
    if (r.errors) json["source_errors"] = errors_json(*r.errors);
    return json;
}

double percent(std::uint64_t part, std::uint64_t whole) {
    return whole == 0 ? 0 : 100 * static_cast<double>(part) / static_cast<double>(whole);
}

void print_text(const UpdateReport& r, const std::string& output) {
    if (r.full)
        fmt::print("closure  the whole file: {} diamonds built anew\n", grouped(r.plan.refined));
    else
        fmt::print(
            "closure  {} of {} diamonds ({:.2f} %) coded anew, {} of them changed: {} are new, {} are gone\n"
            "         {} copied, {} summaries of halves worked out anew\n",
            grouped(r.recoded), grouped(r.plan.refined), percent(r.recoded, r.plan.refined),
            grouped(r.changed), grouped(r.added), grouped(r.removed), grouped(r.copied),
            grouped(r.summaries));
    if (r.errors) print_errors(*r.errors, 1);
    fmt::print("file     {}: {} bytes ({})\n", output, grouped(r.file_bytes), bytes_text(r.file_bytes));
    fmt::print("time     {}:", duration(r.seconds));
    for (const auto& [stage, seconds] : r.stage_seconds)
        fmt::print(" {} {}", to_string(stage), duration(seconds));
    fmt::print("\n");
}

int run(Options o, const Globals& globals) {
    const std::vector<LayerOptions> layers = o.layers.layers();
    if (layers.size() != 1) throw Error(ErrorCode::usage, "update takes one --layer at a time");
    o.update.layer = layers.front();
    o.update.file = o.file;
    o.update.output = o.output;
    o.update.sources.assign(o.sources.begin(), o.sources.end());
    catch_interrupts();
    Progress progress("diamonds", globals.quiet, o.json_progress);
    const UpdateReport report = update_repository(o.update, [&](const BuildProgress& p) {
        const bool samples = p.stage == BuildStage::certifying || p.stage == BuildStage::measuring;
        progress.count(samples ? "samples" : "diamonds");
        return progress.update(to_string(p.stage), p.done, p.total);
    });
    progress.finish();
    for (const std::string& warning : report.plan.warnings) spdlog::warn("{}", warning);
    const std::string output = o.output.empty() ? o.file : o.output;
    if (o.json)
        fmt::print("{}\n", to_json(report, output).dump(2));
    else if (!globals.quiet)
        print_text(report, output);
    if (!report.certification || report.certification->reached()) return kSuccess;
    spdlog::error("{}: no certificate: {} of {} source samples are further than {} m", output,
                  grouped(report.certification->beyond), grouped(report.certification->samples),
                  number(report.certification->bound));
    return kNoCertificate;
}

}  // namespace

void add_update(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("update", "Put a layer into a .carat file without building it anew");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "The .carat file")->required()->type_name(" ");
    const char* group = "The layer (options after --layer apply to it)";
    o->layers.add_lead(sub, "The new layer", group)->required();
    o->layers.add_options(sub, group);
    sub.add_option("--at", o->update.at, "Its place in the order of priority: 1 above all (default)")
        ->type_name("K");
    sub.add_option("--sources", o->sources, "A folder with the file's sources; repeat for more")
        ->type_name("DIR");
    sub.add_option("-o,--output", o->output, "Write here instead of replacing FILE")->type_name("OUT.carat");
    sub.add_flag("--overwrite", o->update.overwrite, "Replace an existing output");
    sub.add_flag("--trust-sources", o->update.trust_sources,
                 "Compare the old sources' sizes only, not their contents, with what the file records");
    sub.add_flag("--measure", o->update.measure,
                 "Compare the result with every source sample and record the errors");
    sub.add_option("--threads", o->update.threads, "Threads (default: all)")
        ->type_name("N")
        ->check(between(1, 1024));
    add_value(sub, "--memory", "SIZE",
              "Most resident memory, at least 256M (default: a quarter of the machine's)",
              [o](const std::string& text) { o->update.memory_bytes = parse_size(text); });
    add_value(sub, "--temp", "DIR", "Folder for temporary files, if the file is built anew",
              [o](const std::string& text) { o->update.temp = text; });
    sub.add_flag("--json-progress", o->json_progress, "Progress as JSON, an object a line, on stderr");
    sub.add_flag("--json", o->json, "Print the report as JSON on stdout");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
