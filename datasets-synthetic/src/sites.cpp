#include "sites.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "carat/synth/synth.hpp"
#include "dual.hpp"
#include "hash.hpp"

namespace carat::synth {
namespace {

constexpr int kCandidates = 16384;
constexpr double kSurveyWavelength = 12e3;  // metres
constexpr double kCloseWavelength = 1e3;
constexpr double kNearCoast = 80;      // metres of height in the survey
constexpr double kRingDegrees = 0.06;  // radius of the ring looked at around a coast
constexpr std::uint64_t kSiteStream = 0x51735;

/// Relief in metres on a ring around g if it is part land, part sea; else 0.
double coast_relief(const Height& height, const Geodetic& g) {
    constexpr int kRing = 12;
    int land = 0;
    double low = 0, high = 0;
    for (int i = 0; i < kRing; ++i) {
        const double turn = 2 * std::numbers::pi * i / kRing;
        const double dx = kRingDegrees * std::cos(turn) / std::cos(g.latitude * std::numbers::pi / 180);
        const Geodetic at{g.latitude + kRingDegrees * std::sin(turn), g.longitude + dx};
        const double h = height(direction(at));
        land += h > 0;
        low = std::min(low, h);
        high = std::max(high, h);
    }
    return land >= kRing / 3 && land <= kRing - kRing / 3 ? high + std::min(high, -low) : 0;
}

}  // namespace

Sites find_sites(std::uint64_t seed) {
    const Height survey = earthlike(seed, kSurveyWavelength), close = earthlike(seed, kCloseWavelength);
    Sequence random(stream_seed(seed, kSiteStream));
    Sites sites;
    double highest = -1e9, best_coast = -1;
    for (int i = 0; i < kCandidates; ++i) {
        const Vec3 v{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
        if (dot(v, v) > 1 || dot(v, v) < 0.01) continue;
        const Geodetic g = geodetic(v);
        if (std::abs(g.latitude) > 60 || std::abs(g.longitude) > 170) continue;
        const double h = survey(normalized(v));
        if (h > highest) {
            highest = h;
            sites.summit = g;
        }
        if (std::abs(h) > kNearCoast) continue;
        if (const double relief = coast_relief(close, g); relief > best_coast) {
            best_coast = relief;
            sites.coast = g;
        }
    }
    return sites;
}

}  // namespace carat::synth
