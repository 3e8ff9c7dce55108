// carat bench stability: errors of vertex positions, jitter and depth, without a GPU.
#include <fmt/core.h>

#include <functional>
#include <map>
#include <memory>
#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/stability.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string csv;
    bool json = false;
    bench::StabilityOptions bench;
};

// Worst over everything but one dimension.
struct Dimension {
    const char* name;
    std::function<std::string(const bench::StabilityRow&)> value;
};

struct Worst {
    std::string value;
    double near_error = 0, error = 0, pixels = 0, share = 0;
};

const std::vector<Dimension>& dimensions() {
    using Row = bench::StabilityRow;
    static const std::vector<Dimension> all{
        {"altitude_m", [](const Row& r) { return number(r.altitude); }},
        {"body", [](const Row& r) { return r.body; }},
        {"place", [](const Row& r) { return r.place; }},
        {"level", [](const Row& r) { return fmt::format("{}", r.level); }},
        {"relief_m", [](const Row& r) { return number(r.relief); }},
        {"tolerance_m", [](const Row& r) { return number(r.tolerance); }}};
    return all;
}

std::vector<Worst> worst_by(const Dimension& d, const std::vector<bench::StabilityRow>& rows) {
    std::vector<Worst> out;
    std::map<std::string, std::size_t> index;
    for (const bench::StabilityRow& r : rows) {
        const std::string value = d.value(r);
        const auto [at, fresh] = index.emplace(value, out.size());
        if (fresh) out.push_back({value});
        Worst& w = out[at->second];
        w.near_error = std::max(w.near_error, r.near_error);
        w.error = std::max(w.error, r.error);
        w.pixels = std::max(w.pixels, r.pixels);
        w.share = std::max(w.share, r.share);
    }
    return out;
}

std::string csv_of(const std::vector<bench::StabilityRow>& rows) {
    std::string csv =
        "body,place,relief_m,tolerance_m,altitude_m,level,near_error_m,error_m,error_px,share_of_bound\n";
    for (const bench::StabilityRow& r : rows)
        csv +=
            fmt::format("\"{}\",\"{}\",{},{},{},{},{:.4g},{:.4g},{:.4g},{:.4f}\n", r.body, r.place, r.relief,
                        r.tolerance, r.altitude, r.level, r.near_error, r.error, r.pixels, r.share);
    return csv;
}

void print(const std::vector<bench::StabilityRow>& rows, const std::vector<bench::JitterRow>& jitter,
           const std::vector<bench::DepthRow>& depth) {
    fmt::print("{} combinations; worst error of a vertex's position, by each dimension\n",
               grouped(rows.size()));
    for (const Dimension& d : dimensions()) {
        fmt::print("\n{:<24} {:>18} {:>12} {:>10} {:>14}\n", d.name, "within 10 m, um", "any, m", "pixels",
                   "share of bound");
        for (const Worst& w : worst_by(d, rows))
            fmt::print("{:<24} {:>18.3f} {:>12.3g} {:>10.4f} {:>14.3f}\n", w.value, 1e6 * w.near_error,
                       w.error, w.pixels, w.share);
    }
    fmt::print("\nEye 1 m above the ground in steps of 0.1 mm, vertices within 10 m; micrometres\n");
    fmt::print("{:<24} {:<22} {:>8} {:>10} {:>10} {:>10} {:>10}\n", "body", "place", "unit", "offset",
               "uneven", "bound", "pixels");
    for (const bench::JitterRow& r : jitter)
        fmt::print("{:<24} {:<22} {:>8.4f} {:>10.3f} {:>10.3f} {:>10.3f} {:>10.5f}\n", r.body, r.place,
                   r.unit, r.offset, r.step, r.bound, r.pixels);
    fmt::print("\n{:>12} {:>18} {:>10} {:>8}\n", "distance, m", "told apart, m", "pairs", "swapped");
    for (const bench::DepthRow& r : depth)
        fmt::print("{:>12g} {:>18.3g} {:>10} {:>8}\n", r.distance, r.separation, r.pairs, r.swapped);
}

Json json_of(const std::vector<bench::StabilityRow>& rows, const std::vector<bench::JitterRow>& jitter,
             const std::vector<bench::DepthRow>& depth) {
    Json out = {{"combinations", rows.size()}};
    for (const Dimension& d : dimensions())
        for (const Worst& w : worst_by(d, rows))
            out["position"][d.name].push_back({{"value", w.value},
                                               {"near_error_m", w.near_error},
                                               {"error_m", w.error},
                                               {"error_px", w.pixels},
                                               {"share_of_bound", w.share}});
    for (const bench::JitterRow& r : jitter)
        out["jitter"].push_back({{"body", r.body},
                                 {"place", r.place},
                                 {"unit_um", r.unit},
                                 {"offset_um", r.offset},
                                 {"uneven_um", r.step},
                                 {"bound_um", r.bound},
                                 {"uneven_px", r.pixels}});
    for (const bench::DepthRow& r : depth)
        out["depth"].push_back({{"distance_m", r.distance},
                                {"told_apart_m", r.separation},
                                {"pairs", r.pairs},
                                {"swapped", r.swapped}});
    return out;
}

int run(const Options& o) {
    const auto rows = bench::measure_stability(o.bench);
    const auto jitter = bench::measure_jitter(o.bench);
    const auto depth = bench::measure_depth(o.bench);
    if (o.json)
        fmt::print("{}\n", json_of(rows, jitter, depth).dump(2));
    else
        print(rows, jitter, depth);
    write_text(o.csv, csv_of(rows));
    return kSuccess;
}

constexpr const char* kFooter = R"(
Computes vertex positions as the shader does, operation by operation, and compares them with the same in long double: for
eyes 0.5 m to 100,000 km above the ground, on nine places of the cube, diamonds of all levels, tolerances 1 mm to 100 m, heights up
to 100 km up and down, bodies from an asteroid of 1 km to Jupiter. Then moves an eye 1 m above the ground in steps
of 0.1 mm and says how unevenly vertices within 10 m follow; then finds how far apart points must be for the depth
buffer to tell them apart. Pixels are thousandths of a radian. --csv has every combination.

Example:
  carat bench stability --csv stability.csv)";

}  // namespace

void add_bench_stability(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("stability", "Errors of vertex positions from asteroids to Jupiter");
    sub.footer(kFooter);
    sub.add_option("--vertices", o->bench.vertices, "Of each combination (default 8)")
        ->check(between(1, 10'000));
    sub.add_option("--seed", o->bench.seed, "Of the random heights and views (default 1)");
    sub.add_flag("--json", o->json, "Print JSON");
    sub.add_option("--csv", o->csv, "Also write every combination here");
    on_run(sub, globals, [o] { return run(*o); });
}

}  // namespace carat::cli
