#include "planet.hpp"

#include <cmath>
#include <numbers>
#include <set>

#include "carat/globe/globe.hpp"
#include "carat/render/octahedral.hpp"

namespace carat::test {

namespace {

constexpr double kRadians = std::numbers::pi / 180;

Vec3 surface_normal(const Ellipsoid& body, const Vec3& n, const HeightFunction& height) {
    const Vec3 east = unit(cross(std::abs(n[2]) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0}, n));
    const Vec3 north = cross(n, east);
    const auto at = [&](const Vec3& step) {
        const Vec3 m = unit(sum(n, scaled(1e-5, step)));
        return body.position(m, height(m));
    };
    const auto difference = [&](const Vec3& step) { return sum(at(step), scaled(-1, at(scaled(-1, step)))); };
    return unit(cross(difference(east), difference(north)));
}

void refine(DiamondId d, std::set<DiamondId>& refined) {
    if (!refined.insert(d).second) return;
    for (int side = 0; side < 2; ++side) {
        if (const auto up = parent(d, side)) refine(*up, refined);
    }
}

void collect(const Half& half, const std::set<DiamondId>& refined, std::vector<Half>& frontier) {
    if (!refined.contains(half.diamond)) {
        frontier.push_back(half);
        return;
    }
    for (const Half& finer : child_halves(half)) collect(finer, refined, frontier);
}

}  // namespace

double dot(const Vec3& a, const Vec3& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
Vec3 cross(const Vec3& a, const Vec3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Vec3 scaled(double k, const Vec3& v) { return {k * v[0], k * v[1], k * v[2]}; }
Vec3 sum(const Vec3& a, const Vec3& b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
Vec3 unit(const Vec3& v) { return scaled(1 / std::sqrt(dot(v, v)), v); }

std::shared_ptr<const PatchMesh> make_mesh(const Ellipsoid& body, const Half& half, int cells,
                                           const HeightFunction& height) {
    const double u = length_unit(body);
    const HalfFrame frame = half_frame(half, cells);
    auto mesh = std::make_shared<PatchMesh>();
    mesh->half = half;
    mesh->anchor = to_units(
        body.position(direction(corners(half.diamond).x[static_cast<std::size_t>(half.side)]), 0), u);
    mesh->vertices.resize(half_vertex_count(cells));
    for (int r = 0; r <= cells; ++r) {
        for (int c = 0; c <= r; ++c) {
            const int i = half.side == 0 ? r : c, j = half.side == 0 ? c : r;
            const Vec3 n = direction(frame.vertex(i, j));
            const double h = height(n);
            const UnitVector p = to_units(body.position(n, h), u);
            PatchVertex& vertex = mesh->vertices[half_vertex_index(i, j)];
            for (std::size_t k = 0; k < 3; ++k) vertex.offset[k] = p[k] - mesh->anchor[k];
            vertex.normal = encode_octahedral(surface_normal(body, n, height));
            vertex.height = static_cast<float>(h);
        }
    }
    return mesh;
}

Patches make_meshes(const Ellipsoid& body, const std::vector<Half>& halves, int cells,
                    const HeightFunction& height) {
    Patches patches;
    for (const Half& half : halves) patches.push_back(make_mesh(body, half, cells, height));
    return patches;
}

std::vector<Half> level_halves(int level) {
    std::vector<Half> halves;
    for (int face = 0; face < kFaces; ++face) {
        for (int side = 0; side < 2; ++side) halves.push_back({root_diamond(face), side});
    }
    for (int l = 0; l < level; ++l) {
        std::vector<Half> finer;
        for (const Half& half : halves) {
            for (const Half& child : child_halves(half)) finer.push_back(child);
        }
        halves = std::move(finer);
    }
    return halves;
}

std::vector<Half> random_cut(int level, int picks, std::mt19937& random) {
    std::set<DiamondId> refined;
    std::normal_distribution<double> gauss;
    for (int p = 0; p < picks; ++p) {
        const RealLattice place = lattice_position({gauss(random), gauss(random), gauss(random)});
        refine(locate(place, level).half.diamond, refined);
    }
    std::vector<Half> frontier;
    for (const Half& half : level_halves(0)) collect(half, refined, frontier);
    return frontier;
}

Camera look_down(const Ellipsoid& body, Geodetic above, double distance, int width, int height,
                 double fov_degrees, double tilt, double roll) {
    const Vec3 n = direction(above);
    const Vec3 down = scaled(-1, n);
    const double longitude = above.longitude * kRadians;
    const Vec3 east{-std::sin(longitude), std::cos(longitude), 0};
    const Vec3 north = cross(n, east);
    const auto turn = [](const Vec3& a, const Vec3& b, double degrees) {
        return sum(scaled(std::cos(degrees * kRadians), a), scaled(std::sin(degrees * kRadians), b));
    };
    Camera camera;
    camera.forward = turn(down, north, tilt);
    const Vec3 up = turn(north, n, tilt);
    camera.right = turn(east, up, roll);
    camera.up = turn(up, scaled(-1, east), roll);
    camera.eye = to_units(scaled(distance, n), length_unit(body));
    camera.vertical_fov = fov_degrees * kRadians;
    camera.width = width;
    camera.height = height;
    return camera;
}

Vec3 eye_metres(const Ellipsoid& body, const Camera& camera) {
    return to_metres(camera.eye, length_unit(body));
}

Vec3 ray(const Camera& camera, double x, double y) {
    const double f = camera.height / (2 * std::tan(camera.vertical_fov / 2));
    const Vec3 sideways = sum(scaled((x - camera.width / 2.0) / f, camera.right),
                              scaled((camera.height / 2.0 - y) / f, camera.up));
    return sum(camera.forward, sideways);
}

std::array<double, 2> project(const Camera& camera, const Vec3& relative) {
    const double f = camera.height / (2 * std::tan(camera.vertical_fov / 2));
    const double z = dot(camera.forward, relative);
    return {camera.width / 2.0 + f * dot(camera.right, relative) / z,
            camera.height / 2.0 - f * dot(camera.up, relative) / z};
}

std::optional<double> hit(const Ellipsoid& body, double h, const Vec3& eye, const Vec3& direction) {
    const Vec3 scale{1 / (body.a() + h), 1 / (body.a() + h), 1 / (body.b() + h)};
    const auto squeezed = [&](const Vec3& v) {
        return Vec3{v[0] * scale[0], v[1] * scale[1], v[2] * scale[2]};
    };
    const Vec3 o = squeezed(eye), d = squeezed(direction);
    const double a = dot(d, d), b = dot(o, d), c = dot(o, o) - 1;
    const double discriminant = b * b - a * c;
    if (discriminant < 0 || b > 0) return std::nullopt;
    return c / (-b + std::sqrt(discriminant));
}

Renderer& RendererTest::renderer(const Ellipsoid& body, int cells, int capacity) {
    RendererOptions options;
    options.validation = true;
    options.cells = cells;
    options.capacity = capacity;
    renderers_.emplace_back(body, length_unit(body), options);
    return renderers_.back();
}

void RendererTest::TearDown() {
    for (const Renderer& r : renderers_) {
        for (const std::string& message : r.messages()) ADD_FAILURE() << "validation: " << message;
    }
}

}  // namespace carat::test
