#include "carat/bench/stability.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "carat/bench/shader_arithmetic.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/cut.hpp"
#include "carat/render/vertex_position.hpp"
#include "carat/render/view.hpp"

namespace carat::bench {
namespace {

constexpr double kPixelsPerRadian = 1000;
constexpr float kNearPlane = 0.1f;  // metres, as the renderer has it
constexpr int kCells = 64, kLog2Cells = 6;

struct NamedBody {
    const char* name;
    double a, b;
};
struct NamedPlace {
    const char* name;
    Geodetic at;
};

// A value every so many, the last one included, for small sweeps.
template <class T>
std::vector<T> thinned(std::vector<T> values, bool small, std::size_t every = 3) {
    if (!small) return values;
    std::vector<T> out;
    for (std::size_t k = 0; k < values.size(); k += every) out.push_back(values[k]);
    if ((values.size() - 1) % every != 0) out.push_back(values.back());
    return out;
}

std::vector<NamedBody> bodies(bool small) {
    return thinned<NamedBody>({{"asteroid 1 km", 1000, 1000},
                               {"asteroid 10 km, flat", 10'000, 7'000},
                               {"Moon", 1'737'400, 1'737'400},
                               {"Earth", 6'378'137, 6'356'752.314245179},
                               {"Mars", 3'396'190, 3'376'200},
                               {"Jupiter", 71'492'000, 66'854'000}},
                              small);
}

std::vector<NamedPlace> places(bool small) {
    const double corner = std::atan(std::sqrt(0.5)) * 180 / std::numbers::pi;
    return thinned<NamedPlace>({{"face centre", {0, 0}},
                                {"north pole", {90, 0}},
                                {"south pole, nearly", {-89.9999999, 17}},
                                {"cube corner", {corner, 45}},
                                {"cube edge, equator", {0, 45}},
                                {"cube edge, 45 N", {45, 0}},
                                {"antimeridian", {-27.5, 180}},
                                {"46.5 N 8 E", {46.5, 8}},
                                {"62 S 133 W", {-62.123456, -133.987654}}},
                               small, 2);
}

// Vertices near a place, at a level.
class Vertices {
  public:
    Vertices(const Geodetic& place, int level)
        : frame_(half_frame(locate(lattice_position(direction(place)), level).half, kCells)),
          location_(locate(lattice_position(direction(place)), level)) {}

    // The nearest one first, then any.
    LatticePoint pick(int k, std::mt19937_64& random) const {
        const auto index = [&](double share) { return static_cast<int>(std::lround(share * kCells)); };
        int i = index(location_.s), j = index(location_.t);
        if (k > 0) {
            std::uniform_int_distribution<int> any(0, kCells);
            i = any(random);
            j = any(random);
        }
        if ((location_.half.side == 0) != (i >= j)) std::swap(i, j);
        return frame_.vertex(i, j);
    }

  private:
    HalfFrame frame_;
    Location location_;
};

// Of the file's quantum, whole.
double whole_quanta(double height, double tolerance) {
    const double quantum = std::exp2(std::min(-8.0, std::floor(std::log2(tolerance / 8))));
    return std::round(height / quantum) * quantum;
}

long double along(const Vec3& axis, const LongVec3& p) {
    return axis[0] * p[0] + axis[1] * p[1] + axis[2] * p[2];
}

// What belongs where shader_position() looks.
LongVec3 reference_view(const Camera& camera, double unit, const LongVec3& vertex) {
    LongVec3 relative{};
    for (std::size_t k = 0; k < 3; ++k)
        relative[k] = vertex[k] - static_cast<long double>(camera.eye[k]) * static_cast<long double>(unit);
    return {along(camera.right, relative), along(camera.up, relative), along(camera.forward, relative)};
}

LongVec3 minus(const LongVec3& p, const LongVec3& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }

double length(const LongVec3& v) {
    return static_cast<double>(std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
}

ViewRequest request_at(const Geodetic& place, double height, double heading, double pitch) {
    ViewRequest r;
    r.eye = place;
    r.height = height;
    r.heading = heading;
    r.pitch = pitch;
    return r;
}

struct Combination {
    const Ellipsoid& body;
    const NamedPlace& place;
    double relief, tolerance, altitude;
    int level;
};

void measure(const Combination& c, int count, std::mt19937_64& random, StabilityRow& row) {
    std::uniform_real_distribution<double> sign(-1, 1);
    const double unit = length_unit(c.body), ground = whole_quanta(c.relief * sign(random), c.tolerance);
    const Camera camera = make_camera(
        c.body, request_at(c.place.at, ground + c.altitude, 180 * sign(random), 90 * sign(random)));
    const ShaderCamera shader(camera, unit);
    const Vertices vertices(c.place.at, c.level);
    for (int k = 0; k < count; ++k) {
        const LatticePoint p = vertices.pick(k, random);
        // Level with the ground, and any height.
        const double height = k % 2 == 0 ? ground : whole_quanta(c.relief * sign(random), c.tolerance);
        const LongVec3 wanted = reference_view(camera, unit, reference_position(c.body, p, height));
        const std::array<float, 3> got = shader_position(shader, vertex_position(c.body, p, height, unit));
        const double error = length({got[0] - wanted[0], got[1] - wanted[1], got[2] - wanted[2]});
        const double distance = length(wanted);
        row.error = std::max(row.error, error);
        if (distance <= 10) row.near_error = std::max(row.near_error, error);
        row.pixels = std::max(row.pixels, kPixelsPerRadian * error / std::max(distance, 0.1));
        row.share = std::max(row.share, error / position_bound(unit, distance));
    }
}

// Moves the eye to its right in steps of 0.1 mm and follows one vertex as long as it is within 10 m.
void creep(Camera camera, const Ellipsoid& body, const LatticePoint& p, double height, int steps,
           JitterRow& row) {
    constexpr long double kStep = 1e-4L;
    const double unit = length_unit(body);
    const UnitVector start = camera.eye, vertex = vertex_position(body, p, height, unit);
    const LongVec3 wanted = reference_position(body, p, height);
    LongVec3 before{};
    for (int s = 0; s <= steps; ++s) {
        LongVec3 relative{};
        for (std::size_t k = 0; k < 3; ++k) {
            const long double eye = static_cast<long double>(start[k]) * unit + s * kStep * camera.right[k];
            camera.eye[k] = std::llround(eye / unit);
            relative[k] = wanted[k] - eye;
        }
        if (length(relative) > 10) return;
        const std::array<float, 3> got = shader_position(ShaderCamera(camera, unit), vertex);
        const LongVec3 off{got[0] - along(camera.right, relative), got[1] - along(camera.up, relative),
                           got[2] - along(camera.forward, relative)};
        row.offset = std::max(row.offset, 1e6 * length(off));
        if (s > 0) row.step = std::max(row.step, 1e6 * length(minus(off, before)));
        before = off;
    }
}

// Two points on a ray at random, `separation` apart along the view axis: whether the device would store the
// further one as the further.
bool order_of_pair(const Ellipsoid& body, double distance, double separation, std::mt19937_64& random,
                   DepthRow& row) {
    std::uniform_real_distribution<double> sign(-1, 1);
    const double unit = length_unit(body);
    const Camera camera = make_camera(body, request_at({89 * sign(random), 180 * sign(random)}, 1e4,
                                                       180 * sign(random), 90 * sign(random)));
    const ShaderCamera shader(camera, unit);
    const double x = 0.6 * sign(random), y = 0.6 * sign(random),
                 near_by = distance * (1 + 0.1 * sign(random));
    std::array<float, 2> depth{};
    for (const std::size_t k : {0u, 1u}) {
        const double z = near_by + (k == 0 ? 0 : separation);
        UnitVector point = camera.eye;
        for (std::size_t c = 0; c < 3; ++c)
            point[c] += std::llround(z * (camera.forward[c] + x * camera.right[c] + y * camera.up[c]) / unit);
        depth[k] = shader_depth(shader_position(shader, point)[2], kNearPlane);
    }
    ++row.pairs;
    row.swapped += depth[1] > depth[0] ? 1 : 0;
    return depth[1] < depth[0];
}

}  // namespace

LongVec3 reference_position(const Ellipsoid& body, const LatticePoint& p, long double height) {
    const auto tangent = [](std::int32_t x) {
        const long double share = static_cast<long double>(x) / static_cast<long double>(kLatticeExtent);
        return std::abs(share) == 1 ? share : std::tan(std::numbers::pi_v<long double> / 4 * share);
    };
    const LongVec3 w{tangent(p.x), tangent(p.y), tangent(p.z)};
    const long double a2 = static_cast<long double>(body.a()) * body.a(),
                      b2 = static_cast<long double>(body.b()) * body.b();
    const LongVec3 e{a2 * w[0], a2 * w[1], b2 * w[2]};
    const long double to_surface = std::sqrt(e[0] * w[0] + e[1] * w[1] + e[2] * w[2]);
    const long double norm = std::sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
    LongVec3 out{};
    for (std::size_t k = 0; k < 3; ++k) out[k] = e[k] / to_surface + height * w[k] / norm;
    return out;
}

// Units: half of one in each component. Floats: a component is rounded twice on its way to metres, its axis
// once, and the sum of three products three times; all of it at most so often 2^-24 of |axis| |relative|.
double position_bound(double unit, double distance) {
    return unit * (std::numbers::sqrt3 / 2 + kPositionRounding) +
           6 * std::numbers::sqrt3 * 0x1p-24 * distance;
}

double jitter_bound(double unit, double distance) {
    return unit * (1 + kPositionRounding) * std::numbers::sqrt3 +
           2 * 6 * std::numbers::sqrt3 * 0x1p-24 * distance;
}

std::vector<StabilityRow> measure_stability(const StabilityOptions& o) {
    std::mt19937_64 random(o.seed);
    std::vector<StabilityRow> rows;
    const auto altitudes = thinned<double>({1e8, 1e7, 1e6, 1e5, 1e4, 1e3, 100, 10, 1, 0.5}, o.small);
    const auto tolerances = thinned<double>({0.001, 0.01, 0.1, 1, 10, 100}, o.small, 2);
    const auto reliefs = thinned<double>({0, 100, 10'000, 100'000}, o.small);
    const auto levels =
        thinned<int>({0, 6, 12, 18, 24, 30, 36, 42, deepest_refinable_level(kLog2Cells) + 1}, o.small, 2);
    for (const NamedBody& b : bodies(o.small)) {
        const Ellipsoid body(b.a, b.b);
        for (const NamedPlace& place : places(o.small))
            for (const double relief : reliefs)
                for (const double tolerance : tolerances)
                    for (const double altitude : altitudes)
                        for (const int level : levels) {
                            StabilityRow row{b.name,    place.name, std::min(relief, 0.1 * b.b),
                                             tolerance, altitude,   level};
                            measure({body, place, row.relief, tolerance, altitude, level}, o.vertices, random,
                                    row);
                            rows.push_back(row);
                        }
    }
    return rows;
}

std::vector<JitterRow> measure_jitter(const StabilityOptions& o) {
    std::mt19937_64 random(o.seed);
    std::vector<JitterRow> rows;
    for (const NamedBody& b : bodies(o.small)) {
        const Ellipsoid body(b.a, b.b);
        const double unit = length_unit(body), ground = whole_quanta(std::min(8000.0, 0.05 * b.b), 1);
        // The level whose vertices are about a metre apart.
        const int level = std::clamp(static_cast<int>(std::lround(2 * std::log2(1.6 * b.a / kCells))), 0,
                                     deepest_refinable_level(kLog2Cells) + 1);
        for (const NamedPlace& place : places(o.small)) {
            JitterRow row{b.name, place.name, 1e6 * unit, 0, 0, 1e6 * jitter_bound(unit, 10), 0};
            const Camera camera = make_camera(body, request_at(place.at, ground + 1, 33, -20));
            const Vertices vertices(place.at, level);
            for (int v = 0; v < 4 * o.vertices; ++v)
                creep(camera, body, vertices.pick(v, random), ground, o.small ? 50 : 1000, row);
            row.pixels = kPixelsPerRadian * 1e-6 * row.step / 10;
            rows.push_back(row);
        }
    }
    return rows;
}

std::vector<DepthRow> measure_depth(const StabilityOptions& o) {
    std::mt19937_64 random(o.seed);
    const Ellipsoid body = Ellipsoid::earth();
    const double unit = length_unit(body);
    std::vector<DepthRow> rows;
    for (const double distance : {0.5, 1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8}) {
        DepthRow row;
        row.distance = distance;
        // Downwards, until a pair is not told apart.
        for (double separation = distance / 16; separation > unit; separation /= 2) {
            bool resolved = true;
            for (int k = 0; k < (o.small ? 200 : 5000); ++k)
                resolved = order_of_pair(body, distance, separation, random, row) && resolved;
            if (!resolved) break;
            row.separation = separation;
        }
        rows.push_back(row);
    }
    return rows;
}

}  // namespace carat::bench
