#include "frame_data.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "carat/render/vector.hpp"

namespace carat {

namespace {

constexpr double kNearPlane = 0.1;  // metres

gpu::vec4 pack(const Vec3& v, double w) {
    return {static_cast<float>(v[0]), static_cast<float>(v[1]), static_cast<float>(v[2]),
            static_cast<float>(w)};
}

// To the space in which the body is a sphere of its equatorial radius.
Vec3 stretched(const Vec3& v, const Ellipsoid& body) { return {v[0], v[1], v[2] * (body.a() / body.b())}; }

void require(bool good, const char* what) {
    if (!good) throw Error(ErrorCode::usage, std::string("draw request: ") + what);
}

bool unit(const Vec3& v) { return std::abs(dot(v, v) - 1) < 1e-6; }

}  // namespace

void check_request(const DrawRequest& request) {
    const Camera& c = request.camera;
    require(c.width > 0 && c.height > 0, "the picture has no pixels");
    require(c.vertical_fov > 0 && c.vertical_fov < std::numbers::pi,
            "the field of view must be between 0 and 180 degrees");
    require(unit(c.right) && unit(c.up) && unit(c.forward), "the camera's axes must be unit vectors");
    require(std::abs(dot(c.right, c.up)) < 1e-6 && std::abs(dot(c.up, c.forward)) < 1e-6 &&
                std::abs(dot(c.right, c.forward)) < 1e-6,
            "the camera's axes must be perpendicular");
    require(unit(request.light.direction), "the light's direction must be a unit vector");
    require(request.light.ambient >= 0 && request.light.ambient <= 1,
            "ambient light must be a share from 0 to 1");
    require(std::isfinite(request.light.exposure) && request.light.exposure >= 0,
            "exposure must not be negative");
    require(std::isfinite(request.light.relief_exaggeration), "the relief exaggeration must be finite");
    require(request.samples >= 1 && request.samples <= 8, "samples must be 1 to 8");
    require(request.wind >= 0 && request.wind <= 100, "the wind must be from 0 to 100 m/s");
    require(std::isfinite(request.near_plane) && request.near_plane >= 0,
            "the near plane must not be behind the eye");
}

gpu::AirData make_air_data(const Ellipsoid& body, const std::optional<Atmosphere>& atmosphere) {
    gpu::AirData data{};
    data.shell = {static_cast<float>(body.a()), 0, static_cast<float>(body.a() / body.b()), 1};
    if (!atmosphere) return data;
    const Atmosphere& a = *atmosphere;
    std::array<double, 3> extinction{};
    for (std::size_t k = 0; k < 3; ++k) extinction[k] = a.mie_scattering[k] + a.mie_absorption[k];
    data.rayleigh = pack(a.rayleigh, 1 / a.rayleigh_height);
    data.mie = pack(a.mie_scattering, 1 / a.mie_height);
    data.mie_extinction = pack(extinction, a.mie_asymmetry);
    data.absorber = pack(a.absorption, a.absorption_middle);
    data.shell.y = static_cast<float>(a.top);
    data.shell.w = static_cast<float>(a.absorption_half_width);
    data.shell_sun = static_cast<float>(a.sun_angular_radius);
    data.ground = static_cast<float>(a.ground_albedo);
    data.multiple = a.multiple_scattering ? 1 : 0;
    return data;
}

gpu::FrameData make_frame_data(const DrawRequest& request, const Ellipsoid& body, double metres_per_unit,
                               const vk::TableTexture& table, const gpu::AirData& air) {
    const Camera& c = request.camera;
    const double vertical = 1 / std::tan(c.vertical_fov / 2);
    const double horizontal = vertical * c.height / c.width;
    const double flattening = body.a() * body.a() / (body.b() * body.b());
    const Light& light = request.light;
    gpu::FrameData data{};
    data.eye_x = c.eye[0];
    data.eye_y = c.eye[1];
    data.eye_z = c.eye[2];
    data.metres_per_unit = static_cast<float>(metres_per_unit);
    data.near_plane = static_cast<float>(request.near_plane > 0 ? request.near_plane : kNearPlane);
    data.right = pack(c.right, horizontal);
    data.up = pack(c.up, vertical);
    data.forward = pack(c.forward, 0);
    data.light = pack(light.direction, light.ambient);
    data.body = pack({1, 1, flattening}, light.exposure);
    data.table = {table.sea_floor, table.sea_level, table.top, static_cast<float>(light.relief_exaggeration)};
    data.eye = pack({double(c.eye[0]) * metres_per_unit, double(c.eye[1]) * metres_per_unit,
                     double(c.eye[2]) * metres_per_unit},
                    0.003 + 0.00512 * request.wind);  // Cox and Munk 1954, a clean surface
    const Vec3 eye = stretched(to_metres(c.eye, metres_per_unit), body);
    const Vec3 sun = stretched(light.direction, body);
    const double distance = std::sqrt(dot(eye, eye));
    data.eye_up = pack(scale(1 / std::max(distance, 1.0), eye), distance - body.a());
    data.sun = pack(scale(1 / length(sun), sun), 0);
    data.background = {request.background[0], request.background[1], request.background[2],
                       static_cast<float>(1 / c.focal_pixels())};
    data.air = air;
    return data;
}

}  // namespace carat
