// carat render: a picture of the planet.
#include <fmt/core.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>

#include "aov_list.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/shadows.hpp"
#include "carat/render/view.hpp"
#include "carat/vulkan/picture.hpp"
#include "carat/vulkan/renderer.hpp"
#include "commands.hpp"
#include "look.hpp"
#include "pipeline_cache.hpp"
#include "render_stats.hpp"
#include "text.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

struct Options {
    std::string file, output, stats;
    std::array<double, 3> eye{};
    ViewRequest view;
    double error = 1, spacing = 1.5;
    AovList aovs;
    Look look;
    RendererOptions renderer;
    int threads = 0;
    bool shadows = false;
    bool overwrite = false;
};

constexpr const char* kFooter = R"(
Refines the planet until no visible patch is further than --error pixels from the surface that the file describes,
and, for the sake of colours and shading, no two neighbouring samples are further apart than --spacing pixels; then draws it with Vulkan: on a GPU where there is one, otherwise in software (Mesa lavapipe).

The eye's height is above the ellipsoid. Heading is clockwise from north, pitch is up from the horizon: -90 looks
straight down. --fov is vertical. --sun gives the direction of the light as seen from the eye: azimuth clockwise from
north, elevation above the horizon; by default it comes from the north-west, 45 degrees high near the ground and
up to 70 from space. --time puts the sun where it stands over the turning Earth or Mars at that moment (low-precision
formulas, 0.01 and 0.05 degrees).

--shadows: the relief casts shadows, whatever stands between ground and sun, on the screen or not; seconds of work. Water and
air know no shadows.

Without a file of colours the surface is coloured by height and latitude. --colors takes a table that is built in, or a
file: GDAL's colour-relief text, "height red green blue" a line, or GMT's .cpt; a line "latitude DEG" begins the colours of
one latitude. --exposure multiplies the light; --tone maps what is brighter than white into 8 bits: .exr files are linear,
whatever it says.

Pictures: .png (and others that OpenImageIO writes), 8 bits sRGB; .exr, linear. --aov needs .exr: all in one file,
channels R G B A (color, A is coverage), Z (depth, metres along the view axis), position.X Y Z (metres from the eye,
body axes; added to position_low.X Y Z in double precision, good to a millimetre at any distance), normal.X Y Z (body axes), height.Y (metres above the datum), latlon.lat lon lat_low lon_low (degrees; the sums lat
+ lat_low and lon + lon_low are good to 1e-12), error.pixels and error.metres (bounds of the patch's distance from the
surface), level.Y (-1: background), source.Y (0 measured, 1 interpolated below the file's samples, 2 synthesised
there, -1 background). Samples at
pixel centres, 32-bit but for color. The header holds worldToCamera and worldToNDC (body axes from the eye, row vectors),
the eye as carat:origin, and units. --stats holds the camera too.

Examples:
  carat render earth.carat --eye 20,10,16e6 --size 1280x720 -o globe.png
  carat render earth.carat --eye -33.4,-70.6,9000 --heading 75 --pitch -8 --size 1920x1080 --error 1 -o andes.png
  carat render earth.carat --eye 36.3,-118.2,6000 --heading 300 --pitch -10 --sun 250,12 --stats cost.json -o dusk.exr
  carat render earth.carat --eye 46.6,7.95,4500 --pitch -12 --aov color,depth,position,latlon -o layers.exr)";

void add_view_options(CLI::App& sub, Options& o) {
    const char* group = "View";
    add_numbers(sub, "--eye", o.eye, "LAT,LON,HEIGHT_M",
                "Place of the eye: degrees, metres above the ellipsoid")
        ->required()
        ->group(group);
    const auto angle = [&](const char* name, double& out, const char* description) {
        add_value(sub, name, "DEG", description, [&out](const std::string& t) {
            out = parse_number(t);
        })->group(group);
    };
    angle("--heading", o.view.heading, "Clockwise from north (default 0)");
    angle("--pitch", o.view.pitch, "Up from the horizon (default -90, straight down)");
    angle("--roll", o.view.roll, "Of the camera about its axis, clockwise (default 0)");
    angle("--fov", o.view.fov, "Vertical angle of view (default 45)");
    add_value(sub, "--size", "WxH", "Pixels (default 1280x720)", [&o](const std::string& text) {
        const auto size = parse_picture_size(text);
        o.view.width = size[0];
        o.view.image_height = size[1];
    })->group(group);
    sub.add_option("--error", o.error, "Greatest error on the screen, pixels (default 1)")
        ->check(CLI::PositiveNumber)
        ->group(group);
    sub.add_option(
           "--spacing", o.spacing,
           "Greatest distance of samples on the screen, pixels, where the file has finer ones; 0: --error "
           "alone decides (default 1.5)")
        ->check(CLI::NonNegativeNumber)
        ->group(group);
}

void add_output_options(CLI::App& sub, Options& o) {
    const char* group = "Output";
    sub.add_option("-o,--output", o.output, "The picture: .png, .exr, ...")->required()->group(group);
    add_value(sub, "--aov", "LIST",
              "Of color, depth, normal, position, height, latlon, error, level, source (default color)",
              [&o](const std::string& text) { o.aovs = AovList::parse(text); })
        ->group(group);
    sub.add_option("--stats", o.stats, "Counters and times as JSON")->type_name("OUT.json")->group(group);
    sub.add_flag("--overwrite", o.overwrite, "Replace existing outputs")->group(group);
    sub.add_option("--device", o.renderer.device, "Vulkan device: part of its name, or its number")
        ->group(group);
    sub.add_option("--threads", o.threads, "Threads (default: all)")
        ->check(CLI::Range(1, 1024))
        ->group(group);
    add_pipeline_cache(sub, o.renderer.pipeline_cache)->group(group);
    sub.add_flag("--validation", o.renderer.validation, "Fail on any message of the Vulkan validation layer")
        ->group(group);
}

void check_output(const std::string& path, bool overwrite) {
    if (!overwrite && !path.empty() && std::filesystem::exists(path))
        throw Error(ErrorCode::usage, path + ": exists already; --overwrite replaces it");
}

// Plain words about what may surprise.
void warn_about_eye(const std::shared_ptr<const Repository>& file, const ViewRequest& view) {
    const std::string& datum = file->header().vertical_datum;
    if (datum != "ellipsoid" && datum != "unstated")
        spdlog::warn(
            "the file's heights are above \"{}\" and drawn as if above the ellipsoid, as the eye's is",
            datum);
    const double ground = Surface(file, 1).sample(lattice_position(direction(view.eye))).height;
    if (view.height < ground)
        spdlog::warn("the eye is {} below the ground, which lies at {:.1f} m",
                     length_text(ground - view.height), ground);
}

int run(Options o, const Globals& globals) {
    const auto begin = std::chrono::steady_clock::now();
    o.view.eye = {o.eye[0], o.eye[1]};
    o.view.height = o.eye[2];
    check_output(o.output, o.overwrite);
    check_output(o.stats, o.overwrite);
    o.aovs.check_output(o.output);
    if (o.look.supersample > 1 && o.aovs.wanted().any())
        throw Error(ErrorCode::usage, "--supersample averages pixels, which only --aov color may be");
    std::optional<tbb::global_control> threads;
    if (o.threads > 0)
        threads.emplace(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(o.threads));

    const auto file = Repository::open(o.file);
    const Ellipsoid body = file->header().ellipsoid();
    const ViewRequest drawn = drawn_view(o.look, o.view);
    const View view(body, drawn);
    const auto colours = chosen_colours(o.look);
    const auto draped = draped_colours(o.look);
    DrawRequest request = draw_request(o.look, drawn, view, body);
    request.aovs = o.aovs.wanted();
    request.shadows = o.shadows;
    warn_about_eye(file, o.view);

    RenderStats stats;
    o.renderer.cells = file->header().cells();
    o.renderer.coloured = draped != nullptr;
    o.renderer.shadowed = o.shadows;
    Renderer renderer(body, view.unit(), o.renderer);
    if (colours) renderer.set_colours(*colours);
    stats.device = renderer.device_name();
    const auto detail = detail_of(o.look, file->header());
    DrawList list = converged_cut(*file, view, o.error * o.look.supersample, o.spacing * o.look.supersample,
                                  draped, detail.get());
    if (o.shadows) stats.shadows = cast_shadows(list, *file, view, request.light.direction, detail.get());
    Frame frame = renderer.draw(request, list.meshes);
    for (const std::string& message : renderer.messages()) throw Error(ErrorCode::io, "Vulkan: " + message);
    frame.colour = shrunk(frame.colour, o.look.supersample);
    if (!is_exr(o.output)) tone_map(frame.colour, o.look.tone);
    write_picture(
        o.output,
        o.aovs.assemble(frame, {list, request.camera, body, view.unit(), o.renderer.cells}, o.output));

    stats.camera = request.camera;
    stats.unit = view.unit();
    stats.cut = list.counters;
    stats.cut.worst_error /= o.look.supersample;
    stats.frame = frame.counters;
    stats.file_bytes = file->file_bytes();
    stats.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    if (!o.stats.empty()) stats.write(o.stats);
    if (list.counters.limited > 0)
        spdlog::warn("{} patches on the deepest level are above {} pixels", list.counters.limited, o.error);
    if (!globals.quiet) fmt::print(stderr, "{}: {}\n", o.output, stats.summary());
    return kSuccess;
}

}  // namespace

void add_render(CLI::App& app, Globals& globals) {
    const auto o = std::make_shared<Options>();
    CLI::App& sub = *app.add_subcommand("render", "Draw a picture of the planet");
    sub.footer(kFooter);
    sub.add_option("FILE", o->file, "A .carat file")->required();
    add_view_options(sub, *o);
    add_look_options(sub, o->look);
    sub.add_flag("--shadows", o->shadows, "The relief casts shadows on the ground")
        ->group("Light and colour");
    add_output_options(sub, *o);
    on_run(sub, globals, [o, &globals] { return run(*o, globals); });
}

}  // namespace carat::cli
