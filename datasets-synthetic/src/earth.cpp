#include "earth.hpp"

#include <algorithm>

#include "bounded.hpp"
#include "hash.hpp"

namespace carat::synth {
namespace {

constexpr double kRadius = 6371007.2;  // metres, authalic
constexpr double kSeaShare = 0.735;
constexpr Vec3 kFoldDirection{2.3, -1.9,
                              2.1};  // stretches the range noise across plate borders; no special axis
constexpr double kHighest = 8500;    // metres; approached, never passed
constexpr double kDeepest = -10800;

enum Stream : std::uint64_t {
    kPlateStream,
    kDriftStream,
    kShearStream,
    kContinentStream,
    kOldBeltStream,
    kProvinceStream,
    kRangeStream,
    kHillStream,
    kGrainStream,
    kAbyssalStream,
    kGullyStream,
    kCraterStream,
    kSeamountStream,
    kSeaStream,
};

/// Continental level to metres: abyss, rise, slope, shelf, coast, plain, upland.
Curve earth_hypsometry() {
    return Curve({{-1.2, -6000},
                  {-0.50, -5600},
                  {-0.26, -5100},
                  {-0.16, -4400},
                  {-0.115, -3300},
                  {-0.075, -700},
                  {-0.06, -170},
                  {-0.035, -60},
                  {0, 0},
                  {0.06, 120},
                  {0.25, 320},
                  {0.55, 620},
                  {1.0, 1100}});
}

/// Sharp-crested octaves, each allowed only where the coarser ones already rise (after Musgrave).
Dual ridged(const std::vector<Octave>& octaves, const DualVec3& p, double gain) noexcept {
    Dual sum, allowed = 1;
    double amplitude = 1;
    for (const Octave& o : octaves) {
        const Dual crest = 1 - 2.0 * soft_abs(octave_noise(o, p), 0.15);
        const Dual signal = crest * soft_positive(crest, 0.05) * allowed;
        sum += o.weight * amplitude * signal;
        allowed = smoothstep(0, 0.6, signal);
        amplitude *= gain;
    }
    return sum;
}

/// Bowl, rim and apron of an impact, per radius 1 and depth 1, worn down.
double crater_profile(double d) noexcept {
    const double bowl = d < 1 ? d * d * d * d * 1.25 - 1 : 0;
    const double t = std::clamp((d - 1) / (kPitReach - 1), 0.0, 1.0);
    return d < 1 ? bowl : 0.25 * (1 - t) * (1 - t) * (1 - t);
}

double cone_profile(double d) noexcept {
    const double t = std::max(0.0, 1 - d / kPitReach);
    return t * t * t;
}

}  // namespace

EarthRelief::EarthRelief(std::uint64_t seed, double limit)
    : plates_(stream_seed(seed, kPlateStream)),
      drift_(make_warp({3600e3, 100e3, 2.1}, 1000e3, 0.5, limit, kRadius, stream_seed(seed, kDriftStream))),
      shear_(make_warp({330e3, 40e3, 2.3}, 50e3, 0.5, limit, kRadius, stream_seed(seed, kShearStream))),
      continents_(make_octaves({3000e3, 40e3, 1.97}, limit, kRadius, stream_seed(seed, kContinentStream))),
      old_belts_(make_octaves({2900e3, 2000e3, 2.0}, limit, kRadius, stream_seed(seed, kOldBeltStream))),
      provinces_(make_octaves({1300e3, 200e3, 2.03}, limit, kRadius, stream_seed(seed, kProvinceStream))),
      ranges_(make_octaves({480e3, 100e3, 1.93}, limit, kRadius, stream_seed(seed, kRangeStream))),
      hills_(make_octaves({160e3, 40e3, 1.91}, limit, kRadius, stream_seed(seed, kHillStream))),
      grain_(make_octaves({24e3, 0, 2.07}, limit, kRadius, stream_seed(seed, kGrainStream))),
      abyssal_hills_(make_octaves({70e3, 0, 1.95}, limit, kRadius, stream_seed(seed, kAbyssalStream))),
      gullies_{make_octaves({80e3, 0, 1.87}, limit, kRadius, stream_seed(seed, kGullyStream)), kRadius, 0.24,
               25e3, 900},
      craters_{60e3, limit < 60e3 ? 0.012 : 0, kRadius, stream_seed(seed, kCraterStream)},
      seamounts_{32e3, limit < 32e3 ? 0.20 : 0, kRadius, stream_seed(seed, kSeamountStream)},
      hypsometry_(earth_hypsometry()) {
    set_sea_level(stream_seed(seed, kSeaStream));
}

EarthRelief::Crust EarthRelief::crust(const Vec3& n) const noexcept {
    const DualVec3 warped = displaced(drift_, n);
    const PlateFields plates = plates_.at(warped);
    const Dual level = 0.45 * plates.crust + 0.75 * fractal(continents_, n, 0.57) + 0.25 * plates.collision +
                       0.18 * plates.belt - sea_;
    return {warped, plates, level};
}

void EarthRelief::set_sea_level(std::uint64_t seed) {
    constexpr std::size_t kSamples = 8192;
    std::vector<double> levels;
    levels.reserve(kSamples);
    Sequence random(seed);
    while (levels.size() < kSamples) {
        const Vec3 v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        if (dot(v, v) > 1 || dot(v, v) < 0.01) continue;
        levels.push_back(crust(normalized(v)).level.v);
    }
    const auto at = levels.begin() + static_cast<std::ptrdiff_t>(kSeaShare * kSamples);
    std::nth_element(levels.begin(), at, levels.end());
    sea_ = *at;
}

EarthRelief::Terrain EarthRelief::terrain(const Vec3& n, const Crust& c) const noexcept {
    const Dual inland = smoothstep(-0.09, 0.10, c.level);
    Terrain t{.inland = inland, .mountains = {}, .rough = {}, .plateau = {}};
    if (inland.v <= 0) return t;
    const Dual province = fractal(provinces_, n, 0.5);
    const Dual old = old_belts_.empty() ? Dual(0)
                                        : hump(octave_noise(old_belts_.front(), c.warped), 0.10) *
                                              smoothstep(-0.1, 0.25, province);
    const Dual young = c.plates.belt + c.plates.collision - c.plates.belt * c.plates.collision;
    const Dual vigour = 0.55 + 0.6 * smoothstep(-0.35, 0.35, province);
    t.mountains = inland * (young * vigour + 0.4 * (1 - young) * old);
    t.rough = inland * smoothstep(-0.25, 0.35, province);
    t.plateau = inland * smoothstep(0.22, 0.34, province) * (1 - t.mountains);
    return t;
}

Dual EarthRelief::ranges(const Vec3& n, const Crust& c, const Terrain& t) const noexcept {
    const Dual arcs = (1 - t.inland) * c.plates.belt;
    if (t.mountains.v <= 0 && arcs.v <= 0) return 0;
    DualVec3 sheared = displaced(shear_, n);
    for (std::size_t k = 0; k < 3; ++k) sheared[k] += kFoldDirection[k] * c.plates.fold;
    const Dual crests = ridged(ranges_, sheared, 0.5);
    return t.mountains * (900.0 + 1500.0 * c.plates.collision + 3700.0 * crests) + arcs * (6400.0 * crests);
}

Dual EarthRelief::sea_floor(const Vec3& n, const Crust& c, const Dual& ocean) const noexcept {
    if (ocean.v <= 0) return 0;
    const Dual sediment = smoothstep(-0.35, -0.7, c.level) * (1 - c.plates.ridge);
    return ocean * (3000.0 * c.plates.ridge - 900.0 * c.plates.rift +
                    (1 - 0.75 * sediment) * (340.0 * fractal(abyssal_hills_, n, 0.5)));
}

EarthRelief::Land EarthRelief::land(const Vec3& n, const Crust& c) const noexcept {
    const Dual ocean = smoothstep(-0.07, -0.20, c.level);
    const Terrain t = terrain(n, c);
    Dual h = hypsometry_(c.level) - 2600.0 * (1 + ocean) * (1 - t.inland) * c.plates.trench;
    h += ranges(n, c, t) + sea_floor(n, c, ocean);
    if (t.inland.v > 0)
        h += 900.0 * t.plateau +
             (90.0 * t.inland + 420.0 * t.rough + 1000.0 * t.mountains) * fractal(hills_, n, 0.52);

    const double rugged =
        std::clamp(0.25 + 0.2 * t.rough.v + 0.7 * t.mountains.v + 0.4 * t.plateau.v, 0.0, 1.0);
    const double grain = (30 + 80 * rugged) * fractal(grain_, n, 0.5).v;
    return {h, rugged * (1 - 0.6 * ocean.v), grain};
}

double EarthRelief::round_features(const Vec3& n, const Dual& level) const noexcept {
    double h = 0;
    const double inland = smoothstep(0.02, 0.12, level).v;
    if (inland > 0 && craters_.density > 0)
        for_each_pit(craters_, n, [&](const Pit& pit) {
            h += inland * 0.016 * pit.radius_m * crater_profile(pit.distance);
        });
    const double ocean = smoothstep(-0.2, -0.4, level).v;
    if (ocean > 0 && seamounts_.density > 0)
        for_each_pit(seamounts_, n, [&](const Pit& pit) {
            const double size = unit(pit.hash, 0);
            h += ocean * (600 + 4200 * size * size * size) * cone_profile(pit.distance);
        });
    return h;
}

double EarthRelief::operator()(const Vec3& n) const noexcept {
    const Crust c = crust(n);
    const Land l = land(n, c);
    double h = l.height.v + l.grain + gully_height(gullies_, n, l.height.gradient(), l.ruggedness);
    h += round_features(n, c.level);
    return -bounded(-bounded(h, 5500, kHighest), 7500, -kDeepest);
}

}  // namespace carat::synth
