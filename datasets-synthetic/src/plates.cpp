#include "plates.hpp"

#include "hash.hpp"

namespace carat::synth {
namespace {

constexpr int kPlates = 26;
constexpr double kContinental = 0.42;  // share of plates that carry a continent
constexpr double kReach = 0.36;        // no plate further away than this acts at a point
constexpr double kCrustReach = 0.34;   // width over which neighbouring crusts blend
constexpr double kRidgeReach = 0.30;
constexpr double kRidgeCrest = 0.05;
constexpr double kRiftReach = 0.004;
constexpr double kSegment = 0.07;  // radii between transform faults
constexpr double kFaultOffset = 0.014;
constexpr double kTrenchReach = 0.022;
constexpr double kBeltCentre = 0.05;  // the belt stands back from the trench
constexpr double kBeltHalfWidth = 0.05;
constexpr double kCollisionReach = 0.11;

Vec3 random_in_ball(Sequence& random) noexcept {
    Vec3 v{};
    do {
        v = {random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    } while (dot(v, v) > 1 || dot(v, v) < 0.01);
    return v;
}

/// The best of a few random directions: the one farthest from the sites placed so far.
template <typename Sites>
Vec3 spaced_direction(const Sites& sites, Sequence& random) {
    Vec3 best{};
    double best_cosine = 2;
    for (int attempt = 0; attempt < 5; ++attempt) {
        const Vec3 v = normalized(random_in_ball(random));
        double nearest = -1;
        for (const auto& s : sites) nearest = std::max(nearest, dot(s.site, v));
        if (nearest < best_cosine) {
            best_cosine = nearest;
            best = v;
        }
    }
    return best;
}

/// a or b, for fields in 0..1: never above 1.
Dual either(const Dual& a, const Dual& b) noexcept { return a + b - a * b; }

double ramp(double lo, double hi, double x) noexcept { return smoothstep(lo, hi, Dual(x)).v; }

Dual along(const DualVec3& p, const Vec3& d) noexcept { return d[0] * p[0] + d[1] * p[1] + d[2] * p[2]; }

/// A random constant in -1..1 on each unit interval of x, joined by short smooth steps.
Dual steps(const Dual& x, std::uint64_t seed) noexcept {
    const auto i = floor_int(x.v);
    const auto level = [&](std::int64_t k) {
        return signed_unit(mix(seed + static_cast<std::uint64_t>(k)), 0);
    };
    const double here = level(i), next = level(i + 1);
    return here + (next - here) * smoothstep(0.86, 1, x - static_cast<double>(i));
}

}  // namespace

/// Two neighbouring plates at a point, the one with the thicker crust over the other, and the distances to
/// both.
struct Plates::Border {
    const Pair& pair;
    Dual a_over;
    Dual a_under;

    /// Positive where the plates approach each other.
    double closing(const Vec3& p) const noexcept { return dot(cross(pair.spin, p), pair.apart); }
    Dual both(double width) const noexcept { return hump(a_over, width) * hump(a_under, width); }
    bool within(double width) const noexcept { return a_over.v < width && a_under.v < width; }
};

Plates::Plates(std::uint64_t seed) {
    Sequence random(seed);
    plates_.reserve(kPlates);
    for (int i = 0; i < kPlates; ++i) {
        const Vec3 site = spaced_direction(plates_, random);
        const double bias = random.uniform(0, 0.16);
        const bool continental = (i * 0.61803398875 - std::floor(i * 0.61803398875)) < kContinental;
        const double crust = continental ? random.uniform(0.5, 1.0) : random.uniform(-1.0, -0.5);
        plates_.push_back({site, bias, crust, random_in_ball(random), random.bits()});
    }
    const auto minus = [](const Vec3& a, const Vec3& b) {
        return Vec3{a[0] - b[0], a[1] - b[1], a[2] - b[2]};
    };
    for (const Plate& over : plates_)
        for (const Plate& under : plates_) {
            if (&over == &under)
                pairs_.emplace_back();
            else
                pairs_.push_back({normalized(minus(under.site, over.site)),
                                  normalized(cross(over.site, under.site)), minus(over.spin, under.spin),
                                  over.seed ^ under.seed, over.crust > 0 && under.crust > 0});
        }
}

PlateFields Plates::at(const DualVec3& p) const noexcept {
    const Vec3 at{p[0].v, p[1].v, p[2].v};
    std::array<double, kPlates> s;
    std::size_t top = 0;
    for (std::size_t i = 0; i < kPlates; ++i) {
        s[i] = dot(at, plates_[i].site) + plates_[i].bias;
        if (s[i] > s[top]) top = i;
    }
    // Distances to the plates near by.
    std::array<std::size_t, kPlates> near{};
    std::array<Dual, kPlates> a;
    std::size_t n = 0;
    const Dual highest = along(p, plates_[top].site) + plates_[top].bias;
    for (std::size_t i = 0; i < kPlates; ++i)
        if (s[top] - s[i] < kReach) {
            a[n] = highest - (along(p, plates_[i].site) + plates_[i].bias);
            near[n++] = i;
        }

    PlateFields f;
    Dual weight;
    Dual second = kReach;
    for (std::size_t k = 0; k < n; ++k) {
        const Dual w = hump(a[k], kCrustReach);
        weight += w;
        f.crust += plates_[near[k]].crust * w;
        if (near[k] != top && a[k].v < second.v) second = a[k];
    }
    f.crust = f.crust / weight;
    f.fold = soft_abs(second, 0.02);

    for (std::size_t k = 0; k < n; ++k)
        for (std::size_t l = k + 1; l < n; ++l) {
            const bool first_over = plates_[near[k]].crust >= plates_[near[l]].crust;
            const std::size_t over = first_over ? k : l, under = first_over ? l : k;
            const Border border{pair(near[over], near[under]), a[over], a[under]};
            if (!border.within(kRidgeReach)) continue;
            const double closing = border.closing(at);
            if (closing < 0.05) add_spreading(border, 0.05 - closing, p, f);
            if (closing > 0 && border.within(kCollisionReach)) add_convergence(border, closing, f);
        }
    return f;
}

void Plates::add_spreading(const Border& b, double opening, const DualVec3& p, PlateFields& f) noexcept {
    const double presence = ramp(0, 0.2, opening);
    // Transform faults: the axis is offset from segment to segment, and with it the age of the sea floor.
    const Dual axis =
        b.a_over - b.a_under + kFaultOffset * steps(along(p, b.pair.strike) * (1 / kSegment), b.pair.seed);
    const Dual crest = kRidgeCrest / sqrt(axis * axis + kRidgeCrest * kRidgeCrest * 0.1);
    const Dual near = presence * b.both(kRidgeReach);
    f.ridge = either(f.ridge, near * (crest / (crest + 1.0)));
    f.rift = either(f.rift, near * hump(axis, kRiftReach));
}

void Plates::add_convergence(const Border& b, double closing, PlateFields& f) noexcept {
    const double push = ramp(0, 0.6, closing);
    f.trench = either(f.trench, push * b.both(kTrenchReach));
    f.belt =
        either(f.belt, push * hump(b.a_over, kBeltHalfWidth) * hump(b.a_under - kBeltCentre, kBeltHalfWidth));
    if (b.pair.continental) f.collision = either(f.collision, push * b.both(kCollisionReach));
}

}  // namespace carat::synth
