// carat build: rasters in, a .carat file out.
#include "carat/preprocess/build.hpp"

#include <fmt/core.h>
#include <spdlog/spdlog.h>

#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <vector>

#include "build_report.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/build_colour.hpp"
#include "colour_files.hpp"
#include "commands.hpp"
#include "interrupt.hpp"
#include "layer_arguments.hpp"
#include "progress.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

struct Options {
    LayerArguments layers;
    BuildOptions build;
    int mode = 0;
    bool json = false, dry_run = false, json_progress = false;
    std::string layer_order = "given";
    std::string coder = "range";
    std::vector<int> orders;
    CLI::Option* tolerance = nullptr;
    std::string output;
    std::vector<std::string> color;  // layers of colours, instead of heights
    std::optional<std::array<double, 4>> color_bounds;
    int color_tolerance = 4;
    std::array<double, 3> base_color{96, 96, 96};
    const CLI::Option* mode_option = nullptr;
};

constexpr const char* kFooter = R"(
Layers come in order of priority: where the first --layer has no data, the next is asked, at last --base-height. A
layer is one or more rasters, separated by commas, that GDAL reads (GeoTIFF, COG, HGT, VRT, NetCDF, PDS, ...) in any
coordinate system, or a picture with --bounds. Options of a layer stand after its --layer and hold for it alone.
NODATA, NaN and infinities are holes.

Every height of the file, at every level of detail, is within --tolerance of the source at the sample. Detail follows the
data: samples lie as close as those of the source that gives the height there, and no closer.

--rms R is another promise: the root mean square of all errors at the file's samples is at most R metres, with the coarsest
quantiser that keeps it; info and verify say which promise a file makes.

--certify M bounds the error at the source's own samples too: the file is refined where it must be until every sample that
alone gives the height at its place is within M of the surface, M being above the tolerance. If --max-level stops that, the
file is written without a certificate, the worst places are listed and the exit status is 3.

The file appears under its name only when it is complete. Work done lies in temporary files: after a crash, a kill or
Ctrl-C the same command with --resume goes on, and the bytes are the same as if nothing had happened; without --resume
what was left is thrown away. The bytes depend on inputs and options alone, not on --threads or --memory. SIZE: a number
and K, M, G or T.

--color writes a file of colours for `carat render --color` and `carat fly --color`: 8-bit sRGB, every channel within
--color-tolerance at every sample of the file, at every level. Transparent pixels and NODATA are holes.

Examples:
  carat build --color bluemarble.jpg --color-tolerance 4/255 -o colours.carat
  carat build --layer world.tif --tolerance 4 -o earth.carat
  carat build --layer alps1.tif,alps2.tif --nodata -9999 --layer world.tif --tolerance 1 -o earth.carat
  carat build --layer dem.tif --geoid egm96-15.pgm --vertical-datum ellipsoid --tolerance 0.5 -o site.carat
  carat build --layer mola.tif --body mars --vertical-datum areoid --tolerance 2 -o mars.carat
  carat build --layer mola.tif --body mars --rms 2 --fit-tables -o mars.carat
  carat build --layer dem.tif --tolerance 1 --dry-run -o earth.carat
  carat build --layer tiles.vrt --tolerance 1 --memory 2G --temp /scratch --resume -o earth.carat)";

void add_layer_options(CLI::App& sub, LayerArguments& layers, std::string& order) {
    const char* group = "Layers (options after a --layer apply to it)";
    layers.add_lead(sub, "A layer; repeat for more, highest priority first", group);
    layers.add_options(sub, group);
    sub.add_option("--layer-order", order,
                   "given (default): priority as on the command line; finest: by the spacing of samples")
        ->type_name("ORDER")
        ->check(CLI::IsMember({"given", "finest"}).description(""))
        ->group(group);
}

void add_file_options(CLI::App& sub, Options& o) {
    BuildOptions& b = o.build;
    const char* group = "The file";
    sub.add_option("-o,--output", o.output, "The .carat file to write")
        ->required()
        ->type_name("OUT.carat")
        ->group(group);
    o.tolerance =
        sub.add_option("--tolerance", b.tolerance, "Greatest error at samples; needed without --rms")
            ->type_name("METRES")
            ->group(group);
    add_value(
        sub, "--rms", "METRES",
        "Root mean square of the errors at the file's own samples: the coarsest step that keeps it (greatest "
        "error: --tolerance, by default 8 times this)",
        [&b](const std::string& text) { b.rms = parse_number(text); })
        ->group(group);
    add_value(sub, "--quantum", "METRES",
              "Unit of heights (default: a power of two, at most 2^-8 m and tolerance/8)",
              [&b](const std::string& text) { b.quantum = parse_number(text); })
        ->group(group);
    add_value(sub, "--body", "BODY", "earth (default), moon, mars or semi-axes A,B in metres",
              [&b](const std::string& text) { b.body = Ellipsoid::parse(text); })
        ->group(group);
    sub.add_option("--vertical-datum", b.vertical_datum,
                   "What heights are above, to be recorded: ellipsoid, egm96, egm2008, areoid, ... (default "
                   "unstated)")
        ->type_name("NAME")
        ->group(group);
    sub.add_option("--base-height", b.base_height, "Height where no layer has data (default 0)")
        ->type_name("METRES")
        ->group(group);
    o.mode_option =
        sub.add_option("--mode", o.mode,
                       "0 interpolating (default), 1 filtered (default of colours), 2 the C-BDAM paper's")
            ->type_name("MODE")
            ->check(between(0, 2))
            ->group(group);
    sub.add_option("--coder", o.coder, "range (default): small; gamma: the C-BDAM paper's, faster to decode")
        ->type_name("CODER")
        ->check(CLI::IsMember({"range", "gamma"}))
        ->group(group);
    sub.add_flag(
           "--fit-tables", b.fit_tables,
           "Range coder: tables fitted to a sample of the data, stored in the file where that saves bytes")
        ->group(group);
    sub.add_option("--orders", o.orders, "Orders of prediction to choose among, by diamond (default 2,4,6)")
        ->delimiter(',')
        ->type_name("LIST")
        ->check(CLI::IsMember({2, 4, 6}).description(""))
        ->group(group);
    sub.add_option("--depth-bias", b.depth_bias, "Levels added to what the data ask, or left out (default 0)")
        ->type_name("LEVELS")
        ->check(between(-20.0, 20.0))
        ->group(group);
    sub.add_option("--max-level", b.max_level, "No diamond of this level or deeper is refined (default 40)")
        ->type_name("LEVEL")
        ->check(between(0, 49))
        ->group(group);
}

void add_run_options(CLI::App& sub, Options& o) {
    BuildOptions& b = o.build;
    const char* group = "The run";
    sub.add_option("--threads", b.threads, "Threads (default: all)")
        ->type_name("N")
        ->check(between(1, 1024))
        ->group(group);
    add_value(sub, "--memory", "SIZE",
              "Most resident memory, at least 256M (default: a quarter of the machine's)",
              [&b](const std::string& text) { b.memory_bytes = parse_size(text); })
        ->group(group);
    add_value(sub, "--certify", "METRES",
              "Refine until every source sample outside feathered zones is this near, and say so in the file",
              [&b](const std::string& text) { b.certify = parse_number(text); })
        ->group(group);
    add_value(sub, "--temp", "DIR", "Folder for temporary files (default: OUT.carat.build beside the output)",
              [&b](const std::string& text) { b.temp = text; })
        ->group(group);
    sub.add_flag("--resume", b.resume,
                 "Go on with what a killed or interrupted build with the same inputs and options left")
        ->group(group);
    sub.add_flag("--measure,!--no-measure", b.measure,
                 "Compare the result with every source sample and record the errors (default yes)")
        ->group(group);
    sub.add_flag("--overwrite", b.overwrite, "Replace an existing output")->group(group);
    sub.add_flag("--dry-run", o.dry_run, "Say what would be built; write nothing")->group(group);
    sub.add_flag("--json-progress", o.json_progress, "Progress as JSON, an object a line, on stderr")
        ->group(group);
    sub.add_flag("--json", o.json, "Print the report as JSON on stdout")->group(group);
}

int parse_color_tolerance(const std::string& text) {
    const std::string number = text.substr(0, text.find('/'));
    const double value = parse_number(number);
    if ((number != text && text.substr(number.size()) != "/255") || value != std::floor(value) || value < 0 ||
        value > 255)
        throw CLI::ValidationError("\"" + text + "\" is no tolerance of colours, such as 4/255");
    return static_cast<int>(value);
}

void add_color_options(CLI::App& sub, Options& o) {
    const char* group = "Colour (a file of its own)";
    sub.add_option("--color", o.color,
                   "Pictures: a layer of colours instead of heights; repeat for more, highest priority first")
        ->type_name("FILE[,FILE...]")
        ->type_size(1)
        ->expected(1)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
        ->group(group);
    add_value(sub, "--color-bounds", "W,S,E,N",
              "Degrees, outer edges of pictures without a georeference (default -180,-90,180,90)",
              [&o](const std::string& text) {
                  const std::vector<double> v = parse_numbers(text, 4);
                  o.color_bounds = {v[0], v[1], v[2], v[3]};
              })
        ->group(group);
    add_value(sub, "--color-tolerance", "N/255", "Greatest error of any channel at samples (default 4/255)",
              [&o](const std::string& text) { o.color_tolerance = parse_color_tolerance(text); })
        ->group(group);
    add_numbers(sub, "--base-color", o.base_color, "R,G,B", "Where no picture has data (default 96,96,96)")
        ->group(group);
}

// Bounds are for files that have none: asked for by what opening without them says.
LayerOptions color_layer(const Options& o, const std::string& files) {
    LayerOptions layer;
    layer.files = parse_files(files);
    layer.bounds = o.color_bounds;
    if (layer.bounds) return layer;
    layer.colour_component = 0;
    try {
        const SourceStack probe({layer}, o.build.body, 0, std::size_t{64} << 20);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::usage) throw;
        layer.bounds = {-180, -90, 180, 90};
    }
    layer.colour_component.reset();
    return layer;
}

int run_color(Options o, const Globals& globals) {
    ColourBuildOptions colour;
    colour.build = o.build;
    colour.build.mode = o.mode_option->count() > 0 ? static_cast<Mode>(o.mode) : Mode::filtered;
    for (const std::string& files : o.color) colour.build.layers.push_back(color_layer(o, files));
    colour.tolerance = o.color_tolerance;
    for (std::size_t c = 0; c < 3; ++c) {
        if (!(o.base_color[c] >= 0 && o.base_color[c] <= 255))
            throw Error(ErrorCode::usage, "--base-color: components are 0 to 255");
        colour.base_colour[c] = static_cast<std::uint8_t>(std::lround(o.base_color[c]));
    }
    Progress progress("diamonds", globals.quiet, o.json_progress);
    const ColourBuildReport report = build_colour(
        colour, [&](const BuildProgress& p) { return progress.update(to_string(p.stage), p.done, p.total); });
    progress.finish();
    for (const std::string& warning : report.planes[0].plan.warnings) spdlog::warn("{}", warning);
    if (o.json || !globals.quiet) print_colour_report(report, colour, o.json);
    return kSuccess;
}

void check_kind(const Options& o) {
    if (o.color.empty()) return;
    if (o.tolerance->count() > 0 || o.build.rms)
        throw Error(ErrorCode::usage,
                    "--tolerance and --rms are for heights; colours have --color-tolerance");
    if (o.build.certify || o.dry_run)
        throw Error(ErrorCode::usage, "--certify and --dry-run are for heights");
}

void warn(const BuildPlan& plan) {
    for (const std::string& warning : plan.warnings) spdlog::warn("{}", warning);
}

int run(Options o, const Globals& globals) {
    o.build.layers = o.layers.layers();
    if (o.build.layers.empty() == o.color.empty())
        throw Error(ErrorCode::usage, o.color.empty()
                                          ? "--layer or --color is required"
                                          : "a file holds heights or colours: --layer or --color");
    check_kind(o);
    if (o.layer_order == "finest") o.build.layers = finest_first(o.build.layers, o.build.body);
    o.build.mode = static_cast<Mode>(o.mode);
    o.build.coding = o.coder == "gamma" ? Coding::gamma() : Coding{};
    if (!o.orders.empty()) o.build.coding.orders = 0;
    for (const int order : o.orders) o.build.coding.orders |= 1u << (order / 2 - 1);
    if (o.color.empty() && o.tolerance->count() == 0) {
        if (!o.build.rms) throw Error(ErrorCode::usage, "how exact? --tolerance METRES or --rms METRES");
        o.build.tolerance = 8 * *o.build.rms;
    }
    o.build.output = o.output;
    catch_interrupts();
    if (!o.color.empty()) return run_color(o, globals);
    Progress progress("diamonds", globals.quiet, o.json_progress);
    const auto show = [&](const BuildProgress& p) {
        const bool samples = p.stage == BuildStage::certifying || p.stage == BuildStage::measuring;
        progress.count(samples ? "samples" : "diamonds");
        return progress.update(to_string(p.stage), p.done, p.total);
    };
    if (o.dry_run) {
        const BuildPlan plan = plan_build(o.build, show);
        progress.finish();
        warn(plan);
        print_plan(plan, o.build, o.json);
        return kSuccess;
    }
    const auto announce = [&](const BuildPlan& plan) {
        if (globals.quiet) return;
        progress.finish();
        fmt::print(stderr, "carat: at most {} of temporary files in {}\n", bytes_text(plan.temporary_bytes),
                   plan.temporary_folder.string());
    };
    const BuildReport report = build_repository(o.build, show, announce);
    progress.finish();
    warn(report.plan);
    if (o.json || !globals.quiet) print_report(report, o.build, o.json);
    if (!report.certification || report.certification->reached()) return kSuccess;
    spdlog::error("{}: no certificate: {} of {} source samples are further than {} m; see --max-level",
                  o.output, grouped(report.certification->beyond), grouped(report.certification->samples),
                  number(report.certification->bound));
    return kNoCertificate;
}

}  // namespace

void add_build(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("build", "Compress elevation models into a .carat file");
    sub.footer(kFooter);
    add_layer_options(sub, o->layers, o->layer_order);
    add_file_options(sub, *o);
    add_color_options(sub, *o);
    add_run_options(sub, *o);
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
