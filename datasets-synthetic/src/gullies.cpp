#include "gullies.hpp"

#include "hash.hpp"

namespace carat::synth {
namespace {

/// sin of `t` turns within 0.001, with a continuous slope.
double sine(double t) noexcept {
    const double r = t - static_cast<double>(floor_int(t + 0.5));
    const double y = 8 * r - 16 * r * std::abs(r);
    return 0.225 * (y * std::abs(y) - y) + y;
}

constexpr double fade(double t) noexcept { return t * t * t * (t * (t * 6 - 15) + 10); }

/// One octave of stripes whose phase advances along `side` (lattice units): cosine and sine parts, of norm
/// near 1.
struct Wave {
    double cosine;
    double sine;
};
Wave stripes(const Vec3& q, const Vec3& side, std::uint64_t seed) noexcept {
    const std::int64_t i = floor_int(q[0]), j = floor_int(q[1]), k = floor_int(q[2]);
    const Vec3 f{q[0] - static_cast<double>(i), q[1] - static_cast<double>(j), q[2] - static_cast<double>(k)};
    const Vec3 t{fade(f[0]), fade(f[1]), fade(f[2])};
    Wave sum{0, 0};
    for (int corner = 0; corner < 8; ++corner) {
        const int x = corner & 1, y = corner >> 1 & 1, z = corner >> 2;
        const double w = (x ? t[0] : 1 - t[0]) * (y ? t[1] : 1 - t[1]) * (z ? t[2] : 1 - t[2]);
        const std::uint64_t h = lattice_hash(i + x, j + y, k + z, seed);
        const double phase = unit(h, 0) + (f[0] - x) * side[0] + (f[1] - y) * side[1] + (f[2] - z) * side[2];
        sum.cosine += w * sine(phase + 0.25);
        sum.sine += w * sine(phase);
    }
    const double norm = 1 / std::sqrt(sum.cosine * sum.cosine + sum.sine * sum.sine + 0.05);
    return {sum.cosine * norm, sum.sine * norm};
}

constexpr double kTurn = 6.283185307179586;
constexpr double kTurnsPerCell = 1.4;
constexpr double kFade = 0.22;    // furrows fade where the land is this share of their own slope
constexpr double kTurning = 2.2;  // and widen, to turn round, below this multiple of their own slope squared
constexpr double kSteering = 0.65;  // share of a furrow's own slope that steers the finer ones

}  // namespace

double gully_height(const Gullies& gullies, const Vec3& p, const Vec3& slope, double strength) noexcept {
    double height = 0;
    Vec3 g = slope;
    for (const Octave& o : gullies.octaves) {
        const double radial = dot(g, p);
        for (std::size_t k = 0; k < 3; ++k) g[k] = (g[k] - radial * p[k]);
        const double width_m = o.wavelength_m / kTurnsPerCell;
        const double own_slope =
            gullies.slope / ((1 + width_m / gullies.longest_m) * (1 + gullies.finest_m / width_m));
        const double fade2 = kFade * kFade * own_slope * own_slope;
        const double turning2 = kTurning * kTurning * own_slope * own_slope * own_slope * own_slope;
        const double steep2 = dot(g, g) / (gullies.radius_m * gullies.radius_m);
        const double across = 1 / (gullies.radius_m * std::sqrt(steep2 + turning2));
        Vec3 side = cross(p, g);
        for (double& s : side) s *= across;

        // In lattice coordinates the wave vector keeps its length under the octave's rotation.
        const double turns = kTurnsPerCell * o.wavelength_m / gullies.radius_m;
        const Vec3 wave_vector{turns * dot(o.rows[0], side), turns * dot(o.rows[1], side),
                               turns * dot(o.rows[2], side)};
        const Wave w = stripes(to_lattice(o, p), wave_vector, o.seed);
        const double slope_here = strength * o.weight * own_slope * steep2 / (steep2 + fade2);
        // A second harmonic narrows the valleys and rounds the spurs between them.
        height += slope_here * width_m / kTurn * (w.cosine - 0.25 * (2 * w.cosine * w.cosine - 1));
        const double tilt = kSteering * slope_here * gullies.radius_m * w.sine * (1 - w.cosine);
        for (std::size_t k = 0; k < 3; ++k) g[k] -= tilt * side[k];
    }
    return height;
}

}  // namespace carat::synth
