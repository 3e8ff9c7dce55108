// carat bench summaries: how much the bounds of a file overestimate.
#include <fmt/core.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/summary_bench.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string file;
    bench::SummaryBenchOptions bench;
    bool json = false;
};

constexpr const char* kFooter = R"(
Compares delta, the bound of the distance between a flat patch and the surface, with the greatest distance found at all
leaf vertices below, and the bounds of heights with the heights, for halves spread over every level.

Example:
  carat bench summaries california.carat)";

void print_text(const Options& o, const std::vector<bench::SummaryRow>& rows) {
    fmt::print("{}\n{:>5} {:>9} {:>9} {:>12} {:>12} {:>8} {:>8} {:>8} {:>8}\n", o.file, "level", "halves",
               "compared", "spacing m", "exact m", "least", "median", "greatest", "range");
    for (const bench::SummaryRow& r : rows)
        fmt::print("{:>5} {:>9} {:>9} {:>12.1f} {:>12.3f} {:>8.3f} {:>8.3f} {:>8.3f} {:>8.3f}{}\n", r.level,
                   r.refined, r.halves, r.spacing, r.exact, r.least, r.median, r.greatest, r.range_median,
                   r.violations > 0 ? "  BOUND VIOLATED" : "");
}

void print_json(const Options& o, const std::vector<bench::SummaryRow>& rows) {
    Json list = Json::array();
    for (const bench::SummaryRow& r : rows)
        list.push_back({{"level", r.level},
                        {"halves", r.refined},
                        {"compared", r.halves},
                        {"spacing_m", r.spacing},
                        {"exact_m", r.exact},
                        {"ratio_min", r.least},
                        {"ratio_median", r.median},
                        {"ratio_max", r.greatest},
                        {"height_range_ratio", r.range_median},
                        {"violations", r.violations}});
    fmt::print("{}\n", Json({{"file", o.file}, {"levels", list}}).dump(2));
}

int run(const Options& o, const Globals& globals) {
    catch_interrupts();
    Progress progress("levels", globals.quiet);
    bench::SummaryBenchOptions options = o.bench;
    options.progress = [&](std::size_t done, std::size_t total) {
        return progress.update("comparing", done, total);
    };
    const std::vector<bench::SummaryRow> rows = bench::bench_summaries(Repository::open(o.file), options);
    progress.finish();
    if (o.json)
        print_json(o, rows);
    else
        print_text(o, rows);
    for (const bench::SummaryRow& r : rows)
        if (r.violations > 0) return kFailure;
    return kSuccess;
}

}  // namespace

void add_bench_summaries(CLI::App& bench_app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub =
        *bench_app.add_subcommand("summaries", "Overestimation of a file's bounds, level by level");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required()->type_name(" ");
    sub.add_option("--vertices", o->bench.vertices_per_level,
                   "Leaf vertices looked at in a level (default 20000000)")
        ->check(between<std::size_t>(1, std::size_t{1} << 40));
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
