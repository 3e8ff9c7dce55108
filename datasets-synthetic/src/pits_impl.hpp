#pragma once

#include "hash.hpp"
#include "pits.hpp"

namespace carat::synth {

template <typename F>
void for_each_pit(const PitClass& c, const Vec3& p, const F& f) {
    // A cell is 3 largest radii wide. A centre is hashed inside its cell and moved onto the sphere; it counts
    // only if it moved by less than 1/3 cell. Its reach is at most 2/3 cell, so the 27 cells around p hold
    // all that matter.
    const double cell = 3 * c.largest_m / c.body_radius_m;
    const std::int64_t first[3] = {floor_int(p[0] / cell) - 1, floor_int(p[1] / cell) - 1,
                                   floor_int(p[2] / cell) - 1};
    for (int k = 0; k < 27; ++k) {
        const std::int64_t i[3] = {first[0] + k % 3, first[1] + k / 3 % 3, first[2] + k / 9};
        const double x = static_cast<double>(i[0]), y = static_cast<double>(i[1]),
                     z = static_cast<double>(i[2]);
        const Vec3 middle{(x + 0.5) * cell, (y + 0.5) * cell, (z + 0.5) * cell};
        const double from_centre = dot(middle, middle);
        if (from_centre > (1 + 1.25 * cell) * (1 + 1.25 * cell)) continue;
        if (const double inner = std::max(0.0, 1 - 1.25 * cell); from_centre < inner * inner) continue;
        const std::uint64_t h = lattice_hash(i[0], i[1], i[2], c.seed);
        const std::uint64_t own = mix(h + 0x51ed270b35ae8d2bULL);
        if (unit(own, 0) >= c.density) continue;
        const Vec3 raw{(x + unit(h, 0)) * cell, (y + unit(h, 21)) * cell, (z + unit(h, 42)) * cell};
        const double l = length(raw);
        if (std::abs(l - 1) > cell / 3) continue;
        const double radius_m = c.largest_m / (1 + unit(own, 21));
        const Vec3 d{p[0] - raw[0] / l, p[1] - raw[1] / l, p[2] - raw[2] / l};
        const double distance = length(d) * c.body_radius_m / radius_m;
        if (distance < kPitReach) f(Pit{distance, radius_m, mix(own + 1)});
    }
}

}  // namespace carat::synth
