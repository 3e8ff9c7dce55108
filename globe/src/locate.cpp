#include "carat/globe/locate.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace carat {
namespace {

double dot(const Vec3& p, const LatticeVector& d) {
    return p[0] * static_cast<double>(d.x) + p[1] * static_cast<double>(d.y) +
           p[2] * static_cast<double>(d.z);
}

// Centre coordinate of the square of half-size s that contains shifted coordinate x.
std::int64_t square_centre(double x, std::int64_t s) {
    const auto last = (2 * kLatticeExtent) / (2 * s) - 1;
    const auto index = static_cast<std::int64_t>(std::floor(x / static_cast<double>(2 * s)));
    return (2 * std::clamp<std::int64_t>(index, 0, last) + 1) * s;
}

}  // namespace

Location locate(const RealLattice& place, int level) {
    assert(level >= 0 && level <= kDeepestId);
    const int face = place.face, ua = face_u_axis(face), va = face_v_axis(face);
    const auto extent = static_cast<double>(kLatticeExtent);
    const double u = place.coordinates[static_cast<std::size_t>(ua)] + extent;
    const double v = place.coordinates[static_cast<std::size_t>(va)] + extent;
    const std::int64_t s = half_size(level);
    const std::int64_t cu = square_centre(u, s), cv = square_centre(v, s);

    LatticeVector square = face_sign(face) * axis_vector(face_axis(face), kLatticeExtent);
    square.at(ua) = cu - kLatticeExtent;
    square.at(va) = cv - kLatticeExtent;
    if (level % 2 == 0) {
        const DiamondId d = DiamondId::of_centre(narrow(square));
        Location l = locate_in(place, {d, 0});
        l.half.side = l.s >= l.t ? 0 : 1;
        l.s = std::clamp(l.s, 0.0, 1.0);
        l.t = std::clamp(l.t, 0.0, 1.0);
        return l;
    }
    // The square's four quarters: the nearest side decides.
    const double du = u - static_cast<double>(cu), dv = v - static_cast<double>(cv);
    LatticeVector side = square;
    if (std::abs(du) >= std::abs(dv))
        side.at(ua) += du < 0 ? -s : s;
    else
        side.at(va) += dv < 0 ? -s : s;
    const DiamondId d = DiamondId::of_centre(narrow(side));
    Location l = locate_in(place, {d, corners(d).x[0] == narrow(square) ? 0 : 1});
    double& high = l.half.side == 0 ? l.s : l.t;
    double& low = l.half.side == 0 ? l.t : l.s;
    high = std::clamp(high, 0.0, 1.0);
    low = std::clamp(low, 0.0, high);
    return l;
}

Location locate_in(const RealLattice& place, const Half& half) {
    const HalfFrame f = half_frame(half, 1);  // legs are orthogonal
    Vec3 offset{};
    for (std::size_t k = 0; k < 3; ++k)
        offset[k] = place.coordinates[k] - static_cast<double>(f.origin[static_cast<int>(k)]);
    const auto squared = [](const LatticeVector& d) { return static_cast<double>(dot(d, d)); };
    return {half, dot(offset, f.u) / squared(f.u), dot(offset, f.v) / squared(f.v)};
}

}  // namespace carat
