#include "flat_patch.hpp"

#include <algorithm>

namespace carat::bench {
namespace {

constexpr std::size_t kKept = 6000;  // half a gigabyte for 65 x 65 diamonds

Vec3 on_patch(const std::vector<Vec3>& positions, double x, double y, int cells) {
    const TriangleWeights w = triangle_weights(x, y, cells);
    Vec3 out{};
    for (std::size_t k = 0; k < 3; ++k)
        out = add(out, scale(w.weight[k], positions[half_vertex_index(w.vertex[k][0], w.vertex[k][1])]));
    return out;
}

}  // namespace

HalfPositions::HalfPositions(const std::shared_ptr<const Repository>& file)
    : surface_(file, std::size_t{512} << 20), body_(file->header().ellipsoid()) {}

std::shared_ptr<const std::vector<Vec3>> HalfPositions::operator()(const Half& half) {
    if (const auto known = by_half_.find(half); known != by_half_.end()) {
        entries_.splice(entries_.begin(), entries_, known->second);
        return known->second->second;
    }
    const RepositoryHeader& header = surface_.repository().header();
    const int cells = header.cells();
    const auto heights = surface_.heights(half.diamond);
    const HalfFrame frame = half_frame(half, cells);
    auto out = std::make_shared<std::vector<Vec3>>();
    out->reserve(half_vertex_count(cells));
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c) {
            const int i = half.side == 0 ? r : c, j = half.side == 0 ? c : r;
            out->push_back(body_.position(direction(frame.vertex(i, j)), heights->at(i, j) * header.quantum));
        }
    entries_.emplace_front(half, out);
    by_half_[half] = entries_.begin();
    if (entries_.size() > kKept) {
        by_half_.erase(entries_.back().first);
        entries_.pop_back();
    }
    return out;
}

// A lattice offset in steps of a frame, whose axes are orthogonal.
std::array<double, 2> steps_of(const HalfFrame& frame, const LatticeVector& offset) {
    const auto along = [&](const LatticeVector& axis) {
        double product = 0, square = 0;
        for (int k = 0; k < 3; ++k) {
            product += static_cast<double>(offset[k]) * static_cast<double>(axis[k]);
            square += static_cast<double>(axis[k]) * static_cast<double>(axis[k]);
        }
        return product / square;
    };
    return {along(frame.u), along(frame.v)};
}

FlatPatch::Within::Within(const FlatPatch& patch, const Half& part) : patch_(patch), side_(part.side) {
    const HalfFrame frame = half_frame(part, patch.cells_);
    origin_ = steps_of(patch.frame_, frame.origin - patch.frame_.origin);
    of_i_ = steps_of(patch.frame_, frame.u);
    of_j_ = steps_of(patch.frame_, frame.v);
}

Vec3 FlatPatch::Within::at(int r, int c) const {
    const int i = side_ == 0 ? r : c, j = side_ == 0 ? c : r;
    const auto index = [&](std::size_t a) {
        return std::clamp(origin_[a] + i * of_i_[a] + j * of_j_[a], 0.0, static_cast<double>(patch_.cells_));
    };
    return on_patch(patch_.positions_, index(0), index(1), patch_.cells_);
}

}  // namespace carat::bench
