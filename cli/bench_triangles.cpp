// carat bench triangles: how many triangles a true pixel takes, and how many it would at least.
#include <fmt/core.h>

#include <map>
#include <memory>

#include "bench.hpp"
#include "carat/bench/triangles.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

struct Options {
    std::string file, csv;
    std::array<int, 2> size{1280, 720};
    bench::TrianglesOptions bench;
};

std::string csv_of(const std::vector<bench::TrianglesRow>& rows) {
    std::string csv =
        "view,triangles,measured_px,exact_delta,exact_quarters,oracle_distance,oracle_shift,paper_plain,"
        "paper_"
        "plain_px,paper,paper_limit_px,nearness,nearness_limit_px\n";
    for (const bench::TrianglesRow& r : rows)
        csv += fmt::format("{},{},{:.4f},{},{},{},{},{},{:.4f},{},{:.4f},{},{:.4f}\n", r.view, r.ours,
                           r.error, r.exact_delta, r.exact_quarters, r.distance, r.shift,
                           r.paper_plain.triangles, r.paper_plain.error, r.paper.triangles, r.paper.limit,
                           r.nearness.triangles, r.nearness.limit);
    return csv;
}

// Sums over the views of a manner. A metric that needed too many in one of them is left out.
struct Sum {
    int views = 0, paper_views = 0, nearness_views = 0;
    double ours = 0, exact_delta = 0, exact_quarters = 0, distance = 0, shift = 0, plain = 0, plain_error = 0,
           error = 0;
    double paper = 0, ours_with_paper = 0, nearness = 0, ours_with_nearness = 0;

    void add(const bench::TrianglesRow& r) {
        ++views;
        const auto own = static_cast<double>(r.ours);
        ours += own;
        exact_delta += static_cast<double>(r.exact_delta);
        exact_quarters += static_cast<double>(r.exact_quarters);
        distance += static_cast<double>(r.distance);
        shift += static_cast<double>(r.shift);
        plain += static_cast<double>(r.paper_plain.triangles);
        error = std::max(error, r.error);
        plain_error = std::max(plain_error, r.paper_plain.error);
        if (r.paper.triangles > 0) {
            ++paper_views;
            paper += static_cast<double>(r.paper.triangles);
            ours_with_paper += own;
        }
        if (r.nearness.triangles > 0) {
            ++nearness_views;
            nearness += static_cast<double>(r.nearness.triangles);
            ours_with_nearness += own;
        }
    }
};

std::string times(double many, double few) { return few > 0 ? fmt::format("{:.2f}", many / few) : "-"; }

int run(Options o, const Globals& globals) {
    catch_interrupts();
    o.bench.width = o.size[0];
    o.bench.height = o.size[1];
    Progress progress("views", globals.quiet);
    o.bench.progress = [&](std::size_t done, std::size_t total) {
        return progress.update("views", done, total);
    };
    const auto rows = bench::measure_triangles(Repository::open(o.file), o.bench);
    progress.finish();
    if (static_cast<int>(rows.size()) < o.bench.views) return kInterrupted;
    std::map<std::string, Sum> sums;
    for (const bench::TrianglesRow& r : rows) {
        sums[r.view].add(r);
        sums["together"].add(r);
    }
    fmt::print(
        "{:<9} {:>5} {:>12} {:>9} | {:>11} {:>10} | {:>12} {:>7} {:>12} {:>7} | {:>12} {:>9} | {:>14} "
        "{:>14}\n",
        "views", "count", "triangles", "error px", "exact delta", "4 of them", "c: distance", "ours/c",
        "c: shift", "ours/c", "a: 1 a pixel", "error px", "a/ours", "b/ours");
    for (const char* name : {"globe", "oblique", "grazing", "ground", "together"}) {
        const auto at = sums.find(name);
        if (at == sums.end()) continue;
        const Sum& s = at->second;
        fmt::print(
            "{:<9} {:>5} {:>12} {:>9.3f} | {:>11.3f} {:>10.3f} | {:>12} {:>7} {:>12} {:>7} | {:>12} {:>9.2f} "
            "| {:>8} ({:>3}) "
            "{:>8} ({:>3})\n",
            name, s.views, grouped(static_cast<std::uint64_t>(s.ours)), s.error, s.exact_delta / s.ours,
            s.exact_quarters / s.ours, grouped(static_cast<std::uint64_t>(s.distance)),
            times(s.ours, s.distance), grouped(static_cast<std::uint64_t>(s.shift)), times(s.ours, s.shift),
            grouped(static_cast<std::uint64_t>(s.plain)), s.plain_error, times(s.paper, s.ours_with_paper),
            s.paper_views, times(s.nearness, s.ours_with_nearness), s.nearness_views);
    }
    write_text(o.csv, csv_of(rows));
    return kSuccess;
}

constexpr const char* kFooter = R"(
Counts the triangles drawn at random views with an error of at most --error pixels by the stored bound, and beside them:
 (c) the least conforming cut, if the error of each patch in the view were known exactly, among all samples of the file:
     by the distance between patch and surface, projected; and by how far points are shifted on the screen. Between
     ours and (c), as shares of ours: if files said the greatest distance of each patch exactly, and if they said it
     for each quarter of it;
 (a) refined while more than so many pixels lie between samples, at the nearest point of a patch (the C-BDAM paper's
     metric): at one triangle a pixel, with the error measured then, and at the error measured in our pictures;
 (b) the same by distance from the eye and level alone.
Errors are measured at all vertices of the file's leaves that are in sight. In brackets, in how many views the metric
gets there with fewer than 20,000 diamonds refined. Half of the views are near --at.

Example:
  carat bench triangles california.carat --at 36.58,-118.29 --views 32 --csv triangles.csv)";

}  // namespace

void add_bench_triangles(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("triangles", "Triangles for a true pixel, and how few would do");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    add_place(sub, "Where half of the views are (default: anywhere)",
              [o](const Geodetic& at) { o->bench.place = at; });
    add_value(sub, "--size", "WxH", "Pixels (default 1280x720)",
              [o](const std::string& text) { o->size = parse_picture_size(text); });
    sub.add_option("--error", o->bench.threshold, "Greatest error on the screen, pixels (default 1)")
        ->check(CLI::PositiveNumber);
    sub.add_option("--views", o->bench.views, "(default 16)")->check(between(1, 100'000));
    sub.add_option("--seed", o->bench.seed, "Of the views (default 1)");
    sub.add_option("--csv", o->csv, "Also write a line a view here");
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
