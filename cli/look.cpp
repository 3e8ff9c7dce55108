#include "look.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "carat/globe/error.hpp"
#include "carat/render/sun.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

// Unit direction towards the light, body frame, from azimuth and elevation at the eye's place.
Vec3 sun_direction(const Geodetic& place, double azimuth, double elevation) {
    constexpr double kRadian = std::numbers::pi / 180;
    const Vec3 up = direction(place);
    const double lon = place.longitude * kRadian, az = azimuth * kRadian, el = elevation * kRadian;
    const Vec3 east{-std::sin(lon), std::cos(lon), 0};
    const Vec3 north{up[1] * east[2] - up[2] * east[1], up[2] * east[0] - up[0] * east[2],
                     up[0] * east[1] - up[1] * east[0]};
    Vec3 out{};
    for (std::size_t k = 0; k < 3; ++k)
        out[k] = std::sin(el) * up[k] + std::cos(el) * (std::sin(az) * east[k] + std::cos(az) * north[k]);
    return out;
}

std::array<double, 2> default_sun(double height, const Ellipsoid& body) {
    return {315, 45 + 25 * std::clamp(height / body.a(), 0.0, 1.0)};
}

// Slopes fade with distance: a sample a pixel from orbit is kilometres wide. 1 below 0.2 % of the radius (13
// km on Earth), 6 above half of it, logarithmic between.
double default_relief(double height, const Ellipsoid& body) {
    const double low = 0.002 * body.a(), high = 0.5 * body.a();
    const double h = std::clamp(height, low, high);
    return 1 + 5 * std::log(h / low) / std::log(high / low);
}

std::array<float, 3> linear_background(const std::array<double, 3>& srgb) {
    std::array<float, 3> out{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (!(srgb[k] >= 0 && srgb[k] <= 255))
            throw Error(ErrorCode::usage, "--background: components are 0 to 255");
        out[k] = srgb_decode(static_cast<float>(srgb[k] / 255));
    }
    return out;
}

Tone parse_tone(const std::string& text) {
    if (text == "none") return Tone::none;
    if (text == "reinhard") return Tone::reinhard;
    if (text == "aces") return Tone::aces;
    throw CLI::ValidationError("\"" + text + "\" is none of none, reinhard, aces");
}

// Unit direction towards the light, body frame.
Vec3 light_direction(const Look& look, const ViewRequest& where, const Ellipsoid& body) {
    if (!look.time.empty()) return direction(subsolar_point(body.name(), julian_date(look.time)));
    const auto sun = look.sun.value_or(default_sun(where.height, body));
    return sun_direction(where.eye, sun[0], sun[1]);
}

}  // namespace

std::optional<ColourTable> chosen_colours(const Look& look) {
    if (look.colours.empty()) return std::nullopt;
    for (const ColourTable* table : {&earth_colours(), &moon_colours(), &mars_colours(), &grey_colours()})
        if (look.colours == table->name) return *table;
    return read_colours(look.colours);
}

std::shared_ptr<const ColourRepository> draped_colours(const Look& look) {
    return look.color.empty() ? nullptr : ColourRepository::open(look.color);
}

std::shared_ptr<const Detail> detail_of(const Look& look, const RepositoryHeader& header) {
    return look.detail ? std::make_shared<const Detail>(header, *look.detail) : nullptr;
}

void add_detail_option(CLI::App& sub, std::optional<DetailOptions>& detail, const char* group) {
    sub.add_option_function<std::vector<std::string>>(
           "--detail",
           [&detail](const std::vector<std::string>& values) {
               detail = DetailOptions::parse(values.empty() ? "" : values[0]);
           },
           "Relief below the file's samples, synthesised: any of seed=N (default 1), amplitude=X (a factor, "
           "default 1), to=METRES (default 0.1), slope=DEGREES (at most, default 35), mode=natural|uniform")
        ->expected(0, 1)
        ->type_name("[LIST]")
        ->group(group);
}

void add_look_options(CLI::App& sub, Look& o) {
    const char* group = "Light and colour";
    const auto sun = add_value(sub, "--sun", "AZ,EL", "Direction of the light seen from the eye, degrees",
                               [&o](const std::string& text) {
                                   const auto v = parse_numbers(text, 2);
                                   o.sun = {v[0], v[1]};
                               })
                         ->group(group);
    add_value(sub, "--time", "UTC", "The sun as it stands then, over the Earth or Mars: 2024-06-21T14:30:00Z",
              [&o](const std::string& text) {
                  julian_date(text);
                  o.time = text;
              })
        ->excludes(sun)
        ->group(group);
    sub.add_option("--color", o.color, "A colour file of carat build --color, draped over the relief")
        ->type_name("FILE")
        ->group(group);
    sub.add_option("--colors", o.colours,
                   "earth, moon, mars, grey, or a colour file of GDAL or GMT (default: by the body)")
        ->type_name("NAME|FILE")
        ->group(group);
    add_value(sub, "--tone", "NAME", "Of 8-bit pictures: none (default: clipped), reinhard or aces",
              [&o](const std::string& text) { o.tone = parse_tone(text); })
        ->group(group);
    sub.add_flag("--sky", o.sky,
                 "The air of the Earth or Mars: sky, haze and coloured light; black space elsewhere")
        ->group(group);
    sub.add_flag("--water", o.water, "A sea with the sun's glint below the sea level of the colours")
        ->group(group);
    sub.add_option("--wind", o.wind, "Over the sea, m/s: how wide the glint is (default 5)")
        ->check(between(0.0, 100.0))
        ->group(group);
    sub.add_option("--ambient", o.ambient,
                   "Share of light from everywhere, 0 to 1 (default 0.08, with --sky 0)")
        ->check(CLI::Range(0.0, 1.0))
        ->group(group);
    sub.add_option("--exposure", o.light.exposure, "Factor on the linear colour (default 1)")
        ->check(CLI::PositiveNumber)
        ->group(group);
    sub.add_option("--relief", o.relief,
                   "Factor on slopes, for shading only (default 1 near the ground, 6 from space)")
        ->check(CLI::PositiveNumber)
        ->group(group);
    add_numbers(sub, "--background", o.background, "R,G,B", "0 to 255, sRGB (default 0,0,0)")->group(group);
    add_detail_option(sub, o.detail, group);
    sub.add_option("--samples", o.samples, "A pixel: 1, 2, 4 (default) or 8")
        ->check(CLI::IsMember({1, 2, 4, 8}))
        ->group(group);
    sub.add_option(
           "--supersample", o.supersample,
           "Draw N x N pixels for one and average them, against flicker; with --samples each (default 1)")
        ->type_name("N")
        ->check(between(1, 8))
        ->group(group);
}

ViewRequest drawn_view(const Look& look, ViewRequest where) {
    where.width *= look.supersample;
    where.image_height *= look.supersample;
    return where;
}

DrawRequest draw_request(const Look& look, const ViewRequest& where, const View& view,
                         const Ellipsoid& body) {
    DrawRequest request;
    request.camera = view.camera();
    request.light = look.light;
    request.light.direction = light_direction(look, where, body);
    request.light.relief_exaggeration = look.relief.value_or(default_relief(where.height, body));
    request.background = linear_background(look.background);
    request.samples = look.samples;
    request.skip_back_patches = true;
    request.light.ambient = look.ambient.value_or(look.sky ? 0 : 0.08);
    request.sky = look.sky;
    request.water = look.water;
    request.wind = look.wind;
    return request;
}

}  // namespace carat::cli
