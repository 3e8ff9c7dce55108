// carat synth: planets from formulas and inputs that are hard to digest.
#include "carat/synth/synth.hpp"

#include <fmt/core.h>

#include <filesystem>
#include <memory>
#include <string>

#include "commands.hpp"
#include "interrupt.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

struct Arguments {
    std::string kind;
    std::string directory;
    synth::Options synth;
};

std::string footer() {
    std::string text = "\nKinds:\n";
    for (const synth::KindInfo& k : synth::kinds())
        text += fmt::format("  {:<14} {}\n", k.name, k.description);
    return text + R"(
Writes GeoTIFF files and manifest.json, which lists them: layer order (finest first), bounds, spacing and formula. The
same kind, options and seed give the same bytes. Prints the paths of the rasters, finest first.

Examples:
  carat synth earth -o planet
  carat synth earth -o planet --size 21600 --seed 7
  carat synth hostile -o hostile)";
}

void parse_type(const std::string& text, synth::SampleType& type) {
    if (text == "float32")
        type = synth::SampleType::float32;
    else if (text == "int16")
        type = synth::SampleType::int16;
    else
        throw CLI::ValidationError("must be float32 or int16");
}

int run(const Arguments& a, const Globals& globals) {
    const synth::Kind kind = synth::kind_of(a.kind);
    catch_interrupts();
    Progress progress("samples", globals.quiet);
    synth::Options options = a.synth;
    options.progress = [&](std::uint64_t done, std::uint64_t total) {
        return progress.update("computing", done, total);
    };
    const std::filesystem::path directory(a.directory);
    const std::vector<synth::Written> files = synth::write(kind, directory, options);
    progress.finish();
    for (const synth::Written& f : files) {
        fmt::print("{}\n", (directory / f.name).string());
        if (globals.verbose)
            fmt::print(stderr, "  {} x {} samples, {} apart: {}\n", f.width, f.height,
                       length_text(f.spacing_m), f.purpose);
    }
    return kSuccess;
}

}  // namespace

void add_synth(CLI::App& app, Globals& globals) {
    const auto a = std::make_shared<Arguments>();
    CLI::App& sub = *app.add_subcommand("synth", "Make analytic planets and hostile inputs as GeoTIFF");
    sub.footer(footer());
    sub.add_option("KIND", a->kind, "What to make: see below")->required();
    sub.add_option("-o,--output", a->directory, "Directory for the files; made if missing")->required();
    sub.add_option("--seed", a->synth.seed, "Which planet of the kind (any number; default 1)");
    sub.add_option("--size", a->synth.size,
                   "Columns of the global raster of earth and moon, even (default 4320 and 2880)");
    sub.add_option("--inset-size", a->synth.inset_size,
                   "Columns and rows of each inset of earth and moon (default 768 to 1200)");
    add_value(sub, "--type", "float32|int16", "Samples of earth and moon (default float32)",
              [a](const std::string& text) { parse_type(text, a->synth.type); });
    sub.add_option(
        "--min-wavelength", a->synth.min_wavelength_m,
        "Metres: finest detail in every file of earth and moon (default: twice each file's spacing)");
    sub.add_flag("--overwrite", a->synth.overwrite, "Replace files that exist");
    on_run(sub, globals, [a, &globals] { return run(*a, globals); });
}

}  // namespace carat::cli
