#include "leaf_surface.hpp"

#include <algorithm>

namespace carat {
namespace {

// One index coordinate along a leg, as a linear function of lattice coordinates. Legs are orthogonal.
std::array<double, 4> along(const LatticeVector& origin, const LatticeVector& leg, int cells) {
    const double scale = cells / static_cast<double>(dot(leg, leg));
    std::array<double, 4> f{};
    for (int k = 0; k < 3; ++k) {
        f[static_cast<std::size_t>(k)] = scale * static_cast<double>(leg[k]);
        f[3] -= f[static_cast<std::size_t>(k)] * static_cast<double>(origin[k]);
    }
    return f;
}

double apply(const std::array<double, 4>& f, const Vec3& p) {
    return f[0] * p[0] + f[1] * p[1] + f[2] * p[2] + f[3];
}

}  // namespace

void FileSurface::heights(const Half& leaf, std::vector<double>& out) const {
    const auto p = surface_.heights(leaf.diamond);
    const double quantum = surface_.repository().header().quantum;
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = quantum * p->values[k];
}

LeafEvaluator::LeafEvaluator(const LeafSurface& surface) : surface_(surface), cells_(surface.cells()) {}

// The longest edge belongs to either half.
bool LeafEvaluator::holds(const Leaf& leaf, const RealLattice& place, double& i, double& j) const {
    if (leaf.face != place.face) return false;
    i = apply(leaf.i, place.coordinates);
    j = apply(leaf.j, place.coordinates);
    const double high = leaf.half.side == 0 ? i : j, low = leaf.half.side == 0 ? j : i;
    return low >= 0 && low <= high && high <= cells_;
}

std::size_t LeafEvaluator::find(const RealLattice& place, double& i, double& j) {
    if (holds(leaves_[current_], place, i, j)) return current_;
    for (std::size_t k = 0; k < kLeaves; ++k)
        if (holds(leaves_[k], place, i, j)) return k;
    const std::size_t k = oldest_;
    oldest_ = (oldest_ + 1) % kLeaves;
    load(leaves_[k], place);
    holds(leaves_[k], place, i, j);  // may miss by rounding; the weights are cut to the half
    return k;
}

void LeafEvaluator::load(Leaf& leaf, const RealLattice& place) const {
    const auto side = static_cast<std::size_t>(cells_ + 1);
    leaf.face = -1;  // stays so if reading fails
    leaf.half = surface_.leaf(place);
    const HalfFrame frame = half_frame(leaf.half, 1);
    leaf.i = along(frame.origin, frame.u, cells_);
    leaf.j = along(frame.origin, frame.v, cells_);
    leaf.heights.resize(side * side);
    surface_.heights(leaf.half, leaf.heights);
    leaf.face = place.face;
}

double LeafEvaluator::operator()(const RealLattice& place) {
    double i = 0, j = 0;
    current_ = find(place, i, j);
    const Leaf& leaf = leaves_[current_];
    // Rounding must not push the place over the longest edge: the other half may be absent.
    if (leaf.half.side == 0)
        j = std::min(i, j);
    else
        i = std::min(i, j);
    const TriangleWeights w = triangle_weights(i, j, cells_);
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (w.weight[k] == 0) continue;  // a corner outside the half
        height += w.weight[k] *
                  leaf.heights[static_cast<std::size_t>(w.vertex[k][0] * (cells_ + 1) + w.vertex[k][1])];
    }
    return height;
}

}  // namespace carat
