#include "noise.hpp"

#include "hash.hpp"

namespace carat::synth {
namespace {

/// A value and its gradient in two vector registers (an extension of GCC and clang; plain IEEE arithmetic).
typedef double Pair __attribute__((vector_size(16)));
struct Lanes {
    Pair vx, yz;
};

/// The ramp of the lattice corner at distance (x, y, z) from the point.
inline Lanes ramp(std::uint64_t lattice, double x, double y, double z) noexcept {
    const std::uint64_t h = mix(lattice);
    const double gx = signed_unit(h, 0), gy = signed_unit(h, 21), gz = signed_unit(h, 42);
    return {Pair{gx * x + gy * y + gz * z, gx}, Pair{gy, gz}};
}

/// Blends a into b by weight t of slope dt along `axis` (1, 2 or 3).
template <int axis>
Lanes blend(const Lanes& a, const Lanes& b, double t, double dt) noexcept {
    const Pair vx = b.vx - a.vx, yz = b.yz - a.yz;
    Lanes r{a.vx + t * vx, a.yz + t * yz};
    (axis == 1 ? r.vx : r.yz)[axis == 2 ? 0 : 1] += dt * vx[0];
    return r;
}

constexpr double fade(double t) noexcept { return t * t * t * (t * (t * 6 - 15) + 10); }
constexpr double fade_slope(double t) noexcept { return 30 * t * t * (t * (t - 2) + 1); }

/// A random rotation: the matrix of a random quaternion, which needs no trigonometry.
std::array<Vec3, 3> random_rotation(Sequence& random) noexcept {
    double a = 0, b = 0, c = 0, d = 0, n = 0;
    do {
        a = random.uniform(-1, 1);
        b = random.uniform(-1, 1);
        c = random.uniform(-1, 1);
        d = random.uniform(-1, 1);
        n = a * a + b * b + c * c + d * d;
    } while (n > 1 || n < 0.01);
    const double s = 2 / n;
    return {Vec3{1 - s * (c * c + d * d), s * (b * c - a * d), s * (b * d + a * c)},
            Vec3{s * (b * c + a * d), 1 - s * (b * b + d * d), s * (c * d - a * b)},
            Vec3{s * (b * d - a * c), s * (c * d + a * b), 1 - s * (b * b + c * c)}};
}

Octave make_octave(double wavelength_m, double weight, double radius_m, std::uint64_t seed) {
    Sequence random(seed);
    Octave o{random_rotation(random), {}, random.bits(), wavelength_m, weight};
    for (Vec3& row : o.rows)
        for (double& m : row) m *= radius_m / wavelength_m;
    for (double& v : o.offset) v = random.uniform(-64, 64);
    return o;
}

}  // namespace

Dual gradient_noise(const Vec3& q, std::uint64_t seed) noexcept {
    const std::int64_t i = floor_int(q[0]), j = floor_int(q[1]), k = floor_int(q[2]);
    const double x = q[0] - static_cast<double>(i), y = q[1] - static_cast<double>(j),
                 z = q[2] - static_cast<double>(k);
    const std::uint64_t h = seed + static_cast<std::uint64_t>(i) * kLatticeX +
                            static_cast<std::uint64_t>(j) * kLatticeY +
                            static_cast<std::uint64_t>(k) * kLatticeZ;
    const double tx = fade(x), dx = fade_slope(x), ty = fade(y), dy = fade_slope(y);
    const auto edge = [&](std::uint64_t lattice, double ey, double ez) {
        return blend<1>(ramp(lattice, x, ey, ez), ramp(lattice + kLatticeX, x - 1, ey, ez), tx, dx);
    };
    const Lanes near = blend<2>(edge(h, y, z), edge(h + kLatticeY, y - 1, z), ty, dy);
    const Lanes far =
        blend<2>(edge(h + kLatticeZ, y, z - 1), edge(h + kLatticeY + kLatticeZ, y - 1, z - 1), ty, dy);
    const Lanes r = blend<3>(near, far, fade(z), fade_slope(z));
    return {r.vx[0], r.vx[1], r.yz[0], r.yz[1]};
}

std::vector<Octave> make_octaves(const Band& band, double limit_m, double radius_m, std::uint64_t seed) {
    std::vector<Octave> octaves;
    std::uint64_t stream = 0;
    for (double l = band.longest_m; l > band.shortest_m && l > limit_m; l /= band.lacunarity)
        octaves.push_back(
            make_octave(l, std::min(1.0, l / limit_m - 1), radius_m, stream_seed(seed, stream++)));
    return octaves;
}

Vec3 to_lattice(const Octave& octave, const Vec3& p) noexcept {
    return {dot(octave.rows[0], p) + octave.offset[0], dot(octave.rows[1], p) + octave.offset[1],
            dot(octave.rows[2], p) + octave.offset[2]};
}

Dual octave_noise(const Octave& octave, const Vec3& p) noexcept {
    const Dual n = gradient_noise(to_lattice(octave, p), octave.seed);
    const auto& r = octave.rows;
    return octave.weight * Dual{n.v, r[0][0] * n.x + r[1][0] * n.y + r[2][0] * n.z,
                                r[0][1] * n.x + r[1][1] * n.y + r[2][1] * n.z,
                                r[0][2] * n.x + r[1][2] * n.y + r[2][2] * n.z};
}

Dual octave_noise(const Octave& octave, const DualVec3& p) noexcept {
    const Dual n = octave_noise(octave, Vec3{p[0].v, p[1].v, p[2].v});
    return {n.v, n.x * p[0].x + n.y * p[1].x + n.z * p[2].x, n.x * p[0].y + n.y * p[1].y + n.z * p[2].y,
            n.x * p[0].z + n.y * p[1].z + n.z * p[2].z};
}

namespace {

template <typename Position>
Dual sum_octaves(const std::vector<Octave>& octaves, const Position& p, double gain) noexcept {
    Dual sum;
    double amplitude = 1;
    for (const Octave& o : octaves) {
        sum += amplitude * octave_noise(o, p);
        amplitude *= gain;
    }
    return sum;
}

}  // namespace

Dual fractal(const std::vector<Octave>& octaves, const Vec3& p, double gain) noexcept {
    return sum_octaves(octaves, p, gain);
}
Dual fractal(const std::vector<Octave>& octaves, const DualVec3& p, double gain) noexcept {
    return sum_octaves(octaves, p, gain);
}

Warp make_warp(const Band& band, double amplitude_m, double gain, double limit_m, double radius_m,
               std::uint64_t seed) {
    Warp w{{}, amplitude_m / radius_m, gain};
    for (std::uint64_t axis = 0; axis < 3; ++axis)
        w.axes[axis] = make_octaves(band, limit_m, radius_m, stream_seed(seed, axis));
    return w;
}

DualVec3 displaced(const Warp& warp, const Vec3& p) noexcept {
    DualVec3 r = variable(p);
    for (std::size_t axis = 0; axis < 3; ++axis)
        r[axis] += warp.amplitude * fractal(warp.axes[axis], p, warp.gain);
    return r;
}

}  // namespace carat::synth
