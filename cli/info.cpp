// carat info: what a file says of itself and what it holds.
#include <fmt/core.h>

#include <cmath>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>

#include "carat/codec/repository.hpp"
#include "carat/codec/verify.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/measure.hpp"
#include "colour_files.hpp"
#include "commands.hpp"
#include "error_report.hpp"
#include "text.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

struct Options {
    std::string file;
    bool json = false;
    bool header_only = false;
};

constexpr const char* kFooter = R"(
Prints the header of a file and, for each level, how many diamonds are refined, how many of these need no bytes
because prediction alone meets the tolerance, and the bytes of the others. Level l has 6 * 2^l diamonds in all; the
spacing is the mean distance of the samples that refinement of the level adds to. The same by layer, as the builder
counted: a diamond belongs to the first layer with samples at its centre, or within 16 samples of it.

--header reads a few kilobytes; without it every page is read once (and its checksum checked).

Examples:
  carat info earth.carat
  carat info --json earth.carat | jq .bytes.file)";

// Mean distance in metres between the samples that diamonds of a level have once refined.
double refined_spacing(const RepositoryHeader& h, int level) {
    const double radius = std::sqrt((2 * h.body_a * h.body_a + h.body_b * h.body_b) / 3);
    const double diamonds = kFaces * std::exp2(level + 1);
    return std::sqrt(4 * std::numbers::pi * radius * radius / diamonds) / h.cells();
}

Json parsed_provenance(const RepositoryHeader& h) {
    Json json = Json::parse(h.provenance, nullptr, false);
    return json.is_discarded() ? Json(h.provenance) : json;
}

// Samples of all layers, as the builder recorded them; 0 if it did not.
std::uint64_t source_samples(const Json& provenance) {
    if (!provenance.is_object()) return 0;
    const auto it = provenance.find("source_samples");
    return it != provenance.end() && it->is_number_unsigned() ? it->get<std::uint64_t>() : 0;
}

Json header_json(const std::string& file, const Repository& repository) {
    const RepositoryHeader& h = repository.header();
    return {{"file", file},
            {"format_version", h.format_version},
            {"attribute", "relief"},
            {"body", {{"name", h.body}, {"a_m", h.body_a}, {"b_m", h.body_b}}},
            {"vertical_datum", h.vertical_datum},
            {"tolerance_m", h.tolerance},
            {"quantum_m", h.quantum},
            {"coder", h.coder},
            {"tables", h.fitted_tables ? "fitted" : "built in"},
            {"rms_tolerance_m", h.rms_tolerance},
            {"n", h.n()},
            {"deepest_level", h.deepest_level},
            {"finest_spacing_m", refined_spacing(h, h.deepest_level - 1)},
            {"min_height_m", h.quantum * h.min_height},
            {"max_height_m", h.quantum * h.max_height},
            {"refined_diamonds", h.refined_diamonds},
            {"bytes", {{"file", repository.file_bytes()}}},
            {"provenance", parsed_provenance(h)}};
}

void add_census(Json& json, const RepositoryHeader& h, const FileCensus& c) {
    json["zero_diamonds"] = c.zero;
    json["pages"] = {{"count", c.pages}, {"parts", c.parts}, {"zero", c.zero_pages}};
    json["bytes"] = {{"file", c.file_bytes},      {"header", c.header_bytes},
                     {"roots", c.root_bytes},     {"directory", c.directory_bytes},
                     {"pages", c.page_bytes},     {"page_index", c.index_bytes()},
                     {"residuals", c.coded_bytes}};
    if (const std::uint64_t samples = source_samples(json["provenance"]); samples > 0) {
        json["source_samples"] = samples;
        json["bits_per_source_sample"] =
            8.0 * static_cast<double>(c.file_bytes) / static_cast<double>(samples);
    }
    std::array<std::uint64_t, 3> modes{};
    json["levels"] = Json::array();
    for (std::size_t l = 0; l < c.levels.size(); ++l) {
        const LevelCensus& level = c.levels[l];
        for (std::size_t m = 0; m < modes.size(); ++m) modes[m] += level.modes[m];
        json["levels"].push_back({{"level", l},
                                  {"spacing_m", refined_spacing(h, static_cast<int>(l))},
                                  {"refined", level.refined},
                                  {"zero", level.zero},
                                  {"residual_bytes", level.coded_bytes},
                                  {"modes", level.modes}});
    }
    json["modes"] = modes;
}

std::string certificate_text(const RepositoryHeader& h) {
    const Json p = parsed_provenance(h);
    if (!p.is_object() || !p.contains("certificate")) return "none";
    return fmt::format("no source sample outside feathered zones is further than {} m ({} samples)",
                       p["certificate"].value("bound_m", 0.0),
                       grouped(p["certificate"].value("samples", std::uint64_t{0})));
}

std::string body_text(const RepositoryHeader& h) {
    return fmt::format("{} (semi-axes {} m, {} m)", h.body.empty() ? "given" : h.body, number(h.body_a),
                       number(h.body_b));
}

void print_header(const std::string& file, const Repository& repository) {
    const RepositoryHeader& h = repository.header();
    const auto line = [](const char* name, const std::string& value) {
        fmt::print("{:<16} {}\n", name, value);
    };
    line("file", fmt::format("{} ({} bytes, {})", file, grouped(repository.file_bytes()),
                             bytes_text(repository.file_bytes())));
    line("format", fmt::format("version {}, {} x {} vertices a diamond", h.format_version, h.n(), h.n()));
    line("body", body_text(h));
    line("vertical datum",
         h.vertical_datum == "unstated" ? "unstated: nobody said what heights are above" : h.vertical_datum);
    line("tolerance", number(h.tolerance) + " m at every sample of the file, at every level");
    line("certificate", certificate_text(h));
    line("quantum", number(h.quantum) + " m");
    line("coder", h.coder + (h.fitted_tables ? ", tables fitted to the data" : ""));
    if (h.rms_tolerance > 0) line("RMS tolerance", fmt::format("{} m", h.rms_tolerance));
    line("heights", fmt::format("{:.3f} m to {:.3f} m", h.quantum * h.min_height, h.quantum * h.max_height));
    line("depth", fmt::format("level {}, finest samples {} apart", h.deepest_level,
                              length_text(refined_spacing(h, h.deepest_level - 1))));
    line("refined", grouped(h.refined_diamonds) + " diamonds");
}

void print_census(const RepositoryHeader& h, const FileCensus& c, std::uint64_t samples) {
    std::array<std::uint64_t, 3> modes{};
    for (const LevelCensus& level : c.levels)
        for (std::size_t m = 0; m < modes.size(); ++m) modes[m] += level.modes[m];
    fmt::print("{:<16} {} without residuals; with residuals: {} in mode 0, {} in mode 1, {} in mode 2\n",
               "modes", grouped(c.zero), grouped(modes[0]), grouped(modes[1]), grouped(modes[2]));
    fmt::print("{:<16} {} in {} parts, {} of them all zero\n", "pages", grouped(c.pages), grouped(c.parts),
               grouped(c.zero_pages));
    fmt::print("{:<16} residuals {}, page indices {}, directory {}, root values {}, header {}\n", "bytes",
               grouped(c.coded_bytes), grouped(c.index_bytes()), grouped(c.directory_bytes),
               grouped(c.root_bytes), grouped(c.header_bytes));
    if (samples > 0)
        fmt::print(
            "{:<16} {} bits a source sample ({} samples)\n", "density",
            fmt::format("{:.4g}", 8.0 * static_cast<double>(c.file_bytes) / static_cast<double>(samples)),
            grouped(samples));
    fmt::print("\n{:>5}  {:>10}  {:>14}  {:>14}  {:>15}  {:>9}\n", "level", "spacing", "refined",
               "of these zero", "residual bytes", "a diamond");
    for (std::size_t l = 0; l < c.levels.size(); ++l) {
        const LevelCensus& level = c.levels[l];
        const std::uint64_t coded = level.refined - level.zero;
        fmt::print("{:>5}  {:>10}  {:>14}  {:>14}  {:>15}  {:>9}\n", l,
                   length_text(refined_spacing(h, static_cast<int>(l))), grouped(level.refined),
                   grouped(level.zero), grouped(level.coded_bytes),
                   coded == 0 ? "-" : grouped(level.coded_bytes / coded));
    }
}

std::string layer_name(const Json& provenance, std::size_t k) {
    const Json layers = provenance.value("layers", Json::array());
    return k < layers.size() ? layers[k].value("name", "?") : "base height";
}

// What the builder counted; taken out of the provenance.
void print_shares(Json& provenance) {
    if (!provenance.is_object() || !provenance.contains("shares")) return;
    fmt::print("\n{:<32}  {:>14}  {:>14}  {:>15}\n", "layer at a diamond's centre", "refined",
               "of these zero", "residual bytes");
    std::size_t k = 0;
    for (const Json& s : provenance["shares"])
        fmt::print("{:<32}  {:>14}  {:>14}  {:>15}\n", layer_name(provenance, k++),
                   grouped(s.value("refined", std::uint64_t{0})), grouped(s.value("zero", std::uint64_t{0})),
                   grouped(s.value("residual_bytes", std::uint64_t{0})));
    provenance.erase("shares");
}

// What the builder measured; taken out of the provenance, which is printed as JSON.
void print_source_errors(Json& provenance) {
    if (!provenance.is_object() || !provenance.contains("source_errors")) return;
    const ErrorSummary errors = error_summary_of_json(provenance["source_errors"].dump());
    provenance.erase("source_errors");
    fmt::print("\n");
    print_errors(errors, 1);
}

int run(const Options& o) {
    if (is_colour_file(o.file)) {
        print_colour_info(o.file, o.json, o.header_only);
        return kSuccess;
    }
    const auto repository = Repository::open(o.file);
    Json json = header_json(o.file, *repository);
    FileCensus census;
    if (!o.header_only) {
        census = take_census(o.file);
        add_census(json, repository->header(), census);
    }
    if (o.json) {
        fmt::print("{}\n", json.dump(2));
        return kSuccess;
    }
    print_header(o.file, *repository);
    if (!o.header_only) print_census(repository->header(), census, source_samples(json["provenance"]));
    if (!o.header_only) print_shares(json["provenance"]);
    print_source_errors(json["provenance"]);
    if (const Json& p = json["provenance"]; !p.empty()) fmt::print("\nprovenance {}\n", p.dump(2));
    return kSuccess;
}

}  // namespace

void add_info(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("info", "Say what a .carat file holds");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required()->type_name(" ");
    sub.add_flag("--json", o->json, "Print JSON");
    sub.add_flag("--header", o->header_only, "The header only: no pages are read");
    on_run(sub, globals, [o] { return run(*o); });
}

}  // namespace carat::cli
