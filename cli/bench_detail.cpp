// carat bench detail: whether synthesised relief goes on as the data do, and how fast it is made.
#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "bench.hpp"
#include "carat/bench/detail_spectrum.hpp"
#include "carat/bench/svg.hpp"
#include "look.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string file, csv, svg;
    std::optional<DetailOptions> detail;
    bench::DetailBenchOptions bench;
    bool json = false;
};

constexpr const char* kFooter = R"(
Draws leaves of the file at random places, takes profiles along their rows, sixteen samples a spacing, and prints the mean
power of the relief by wavelength: of the surface in the file, linear between samples, and with --detail. The slopes are those of
the power's logarithm over that of the wavelength: of the data over 32 to 4 spacings, of both surfaces over 1 to 1/4. Then how many new samples a second of
processor time one core decodes (the parents of these leaves) and synthesises (the leaves), children's heights included.

Example:
  carat bench detail earth.carat --bounds -119,36,-118,37 --csv spectrum.csv --svg spectrum.svg)";

std::string csv_of(const bench::DetailSpectrum& s) {
    std::string out = "wavelength_spacings,power_before,power_after\n";
    for (const bench::SpectrumRow& r : s.rows)
        out += fmt::format("{:.4f},{:.6g},{:.6g}\n", r.wavelength, r.before, r.after);
    return out;
}

std::string svg_of_spectrum(const bench::DetailSpectrum& s) {
    bench::Plot plot{"Power of the relief along a row", "cycles a spacing of the leaf", "m2 spacings", {}};
    bench::PlotSeries before{"data, linear between samples", {}, {}, false},
        after{"with detail", {}, {}, true};
    for (const bench::SpectrumRow& r : s.rows) {
        before.x.push_back(1 / r.wavelength);
        before.y.push_back(r.before);
        after.x.push_back(1 / r.wavelength);
        after.y.push_back(r.after);
    }
    plot.series = {before, after};
    return bench::svg_of({plot});
}

int run(Options o) {
    o.bench.detail = o.detail.value_or(DetailOptions{});
    const auto file = Repository::open(o.file);
    const bench::DetailSpectrum s = bench::measure_detail(file, o.bench);
    write_text(o.csv, csv_of(s));
    write_text(o.svg, svg_of_spectrum(s));
    if (o.json) {
        Json rows = Json::array();
        for (const bench::SpectrumRow& r : s.rows)
            rows.push_back({{"wavelength_spacings", r.wavelength}, {"before", r.before}, {"after", r.after}});
        fmt::print("{}\n", Json{{"leaves", s.leaves},
                                {"profiles", s.profiles},
                                {"data_slope", s.data_slope},
                                {"linear_slope", s.before_slope},
                                {"detail_slope", s.detail_slope},
                                {"continued", s.continued},
                                {"decoded_per_core_second", s.decoded_per_second},
                                {"synthesised_per_core_second", s.synthesised_per_second},
                                {"spectrum", rows}}
                               .dump(2));
        return kSuccess;
    }
    fmt::print("{} leaves, {} profiles\n{:>12} {:>12} {:>12}\n", s.leaves, s.profiles, "wavelength", "before",
               "after");
    for (const bench::SpectrumRow& r : s.rows)
        fmt::print("{:>12.3f} {:>12.4g} {:>12.4g}\n", r.wavelength, r.before, r.after);
    fmt::print(
        "slopes: data {:.2f} (32 to 4 spacings), linear {:.2f} and detail {:.2f} (1 to 1/4)\n"
        "power of detail over the data's line: {:.2f}\n"
        "samples a core second: {:.1f} M decoded, {:.1f} M synthesised\n",
        s.data_slope, s.before_slope, s.detail_slope, s.continued, s.decoded_per_second / 1e6,
        s.synthesised_per_second / 1e6);
    return kSuccess;
}

}  // namespace

void add_bench_detail(CLI::App& bench, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *bench.add_subcommand("detail", "Spectrum and speed of procedural detail");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    add_value(sub, "--bounds", "W,S,E,N", "Where leaves are drawn from, degrees (default: anywhere)",
              [o](const std::string& text) {
                  const auto v = parse_numbers(text, 4);
                  o->bench.bounds = {v[0], v[1], v[2], v[3]};
              });
    add_detail_option(sub, o->detail, "Options");
    sub.add_option("--leaves", o->bench.leaves, "Drawn (default 150)")->check(CLI::Range(1, 100'000));
    sub.add_option("--rounds", o->bench.rounds, "Of the rates, the best counts (default 5)")
        ->check(CLI::Range(1, 1000));
    sub.add_option("--csv", o->csv, "The spectrum, to a file");
    sub.add_option("--svg", o->svg, "A plot of it, to a file");
    sub.add_flag("--json", o->json, "Print JSON");
    on_run(sub, globals, [o] { return run(*o); });
}

}  // namespace carat::cli
