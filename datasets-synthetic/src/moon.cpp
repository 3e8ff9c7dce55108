#include "moon.hpp"

#include "bounded.hpp"
#include "hash.hpp"

namespace carat::synth {
namespace {

constexpr double kRadius = 1737400;  // metres
constexpr double kHighest = 10500;
constexpr double kDeepest = -9500;
constexpr double kLargestCrater = 160e3;  // radius, metres

enum Stream : std::uint64_t { kHighlandStream, kGrainStream, kBasinStream, kCraterStream };

double step(double lo, double hi, double x) noexcept { return smoothstep(lo, hi, Dual(x)).v; }

/// Rim height over depth below the surroundings.
constexpr double kRim = 0.22;

/// A crater of depth 1 at distance d radii: 0 -> -1 (simple) or a flat floor (`flat` = 1), rim at 1, apron
/// beyond.
double crater_profile(double d, double flat) noexcept {
    if (d >= 1) {
        const double t = (kPitReach - d) / (kPitReach - 1);
        return kRim * t * t * t;
    }
    const double bowl = d * d;
    const double wall = step(0.55, 1, d);
    return (1 + kRim) * (bowl + flat * (wall - bowl)) - 1;
}

/// Depth in metres of a fresh crater (after Pike 1977: 0.2 diameters, above 15 km 1.04 D^0.3 km), rationally
/// approximated.
double fresh_depth(double radius_m) noexcept {
    const double diameter = 2 * radius_m;
    return 0.2 * diameter / (1 + diameter / 22e3) + 0.006 * diameter * 60e3 / (60e3 + diameter);
}

double crater_height(const Pit& pit) noexcept {
    const double age = unit(pit.hash, 0);
    const double fresh = 1 - 0.85 * age;
    const double flat = step(6e3, 16e3, pit.radius_m);
    const double depth = fresh_depth(pit.radius_m) * fresh;
    const double peak = 0.4 * flat * step(0.22, 0, pit.distance);
    return depth * (crater_profile(pit.distance, flat) + peak);
}

}  // namespace

MoonRelief::MoonRelief(std::uint64_t seed, double limit)
    : highlands_(make_octaves({2200e3, 150e3, 2.0}, limit, kRadius, stream_seed(seed, kHighlandStream))),
      grain_(make_octaves({120e3, 0, 2.05}, limit, kRadius, stream_seed(seed, kGrainStream))),
      basins_{520e3, 0.75, kRadius, stream_seed(seed, kBasinStream)} {
    std::uint64_t stream = kCraterStream;
    for (double r = kLargestCrater; r / 2 > limit; r /= 1.5, ++stream) {
        const double density = r > 60e3 ? 0.35 : 0.9;
        craters_.push_back(
            {{r, density, kRadius, stream_seed(seed, stream)}, std::min(1.0, r / 2 / limit - 1)});
    }
}

double MoonRelief::operator()(const Vec3& n) const noexcept {
    const double highlands = 5600 * fractal(highlands_, n, 0.5).v;
    // Basins: broad bowls, their floors flooded to a common level and smoother than the rest.
    double bowl = 0;
    for_each_pit(basins_, n, [&](const Pit& pit) { bowl += 2600 * crater_profile(pit.distance, 1); });
    const double dry = highlands + bowl;
    const double mare = step(-1900, -2600, dry);
    double h = dry + mare * 0.85 * (-2500 - dry);
    h += (520 - 440 * mare) * fractal(grain_, n, 0.5).v;
    for (const Size& size : craters_) {
        const double keep = size.weight * (size.pits.largest_m > 5e3 ? 1 - 0.9 * mare : 1 - 0.5 * mare);
        for_each_pit(size.pits, n, [&](const Pit& pit) { h += keep * crater_height(pit); });
    }
    return -bounded(-bounded(h, 6500, kHighest), 6500, -kDeepest);
}

}  // namespace carat::synth
