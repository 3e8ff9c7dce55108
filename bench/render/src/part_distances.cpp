#include "part_distances.hpp"

#include <algorithm>

#include "carat/render/vector.hpp"

namespace carat::bench {
namespace {

std::array<Half, 4> quarters_of(const Half& half) {
    std::array<Half, 4> out;
    std::size_t k = 0;
    for (const Half& child : child_halves(half))
        for (const Half& grandchild : child_halves(child)) out[k++] = grandchild;
    return out;
}

}  // namespace

bool PartDistances::refined(const Half& half) const {
    return half.diamond.level() < file_.header().deepest_level && file_.refined(half.diamond);
}

const QuarterDistances& PartDistances::operator()(const Half& half) {
    if (const auto at = known_.find(half); at != known_.end()) return at->second;
    const auto vertices = positions_(half);
    QuarterDistances out{};
    measure({half, *vertices, file_.header().cells()}, half, 0, 0, out);
    return known_[half] = out;
}

// A leaf that spans several quarters counts in each.
void PartDistances::measure(const FlatPatch& flat, const Half& part, int depth, std::size_t quarter,
                            QuarterDistances& out) {
    if (refined(part)) {
        const std::array<Half, 2> children = child_halves(part);
        for (const std::size_t k : {0u, 1u})
            measure(flat, children[k], depth + 1, depth < 2 ? 2 * quarter + k : quarter, out);
        return;
    }
    const auto samples = positions_(part);
    const FlatPatch::Within patch(flat, part);
    double greatest = 0;
    std::size_t k = 0;
    for (int r = 0; r <= file_.header().cells(); ++r)
        for (int c = 0; c <= r; ++c, ++k)
            greatest = std::max(greatest, length(subtract(patch.at(r, c), (*samples)[k])));
    const std::size_t count = std::size_t{4} >> std::min(depth, 2);
    for (std::size_t q = quarter * count; q < (quarter + 1) * count; ++q) out[q] = std::max(out[q], greatest);
}

double bound_by_parts(const Repository& file, const Visibility& visibility, const Half& half, Parts parts,
                      double rounding, PartDistances& distances) {
    const HalfSummary s = file.summary(half);
    const Ellipsoid body = file.header().ellipsoid();
    const QuarterDistances& known = distances(half);
    const auto bound = [&](const Half& part, double distance) {
        HalfVolume volume = half_volume(body, part, s.min_height, s.max_height, rounding);
        if (visibility.cull(volume) != Culled::none) return 0.0;
        volume.slack += distance;  // with the patch's points in it
        return visibility.screen_error(volume, distance + rounding);
    };
    if (parts == Parts::whole) return bound(half, *std::max_element(known.begin(), known.end()));
    double worst = 0;
    const std::array<Half, 4> quarters = quarters_of(half);
    for (std::size_t k = 0; k < quarters.size(); ++k) worst = std::max(worst, bound(quarters[k], known[k]));
    return worst;
}

}  // namespace carat::bench
