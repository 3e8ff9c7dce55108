#include "exact_error.hpp"

#include <algorithm>
#include <cmath>

#include "carat/globe/patch.hpp"
#include "carat/render/cut.hpp"
#include "carat/render/vector.hpp"
#include "flat_patch.hpp"

namespace carat::bench {
namespace {

std::array<double, 2> index_of(const HalfFrame& frame, const LatticePoint& p) {
    return steps_of(frame, wide(p) - frame.origin);
}

}  // namespace

ExactError::ExactError(const std::shared_ptr<const Repository>& file, const Visibility& visibility,
                       HalfPositions& positions)
    : file_(file),
      visibility_(visibility),
      positions_(positions),
      body_(file->header().ellipsoid()),
      cells_(file->header().cells()),
      survey_(*file, body_) {}

HalfVolume ExactError::volume(const FreeHalf& half, double margin) {
    if (!refined(half)) {
        const HalfRange& range = range_of(half);
        return half_volume(body_, half.half, range.min, range.max, margin);
    }
    const HalfSummary s = file_->summary(half.half);
    return half_volume(body_, half.half, s.min_height, s.max_height, margin);
}

bool ExactError::refined(const FreeHalf& half) const {
    const DiamondId d = half.half.diamond;
    return !half.is_virtual() && d.level() < file_->header().deepest_level && file_->refined(d);
}

double ExactError::greatest(const FreeHalf& half, Measure measure, double floor, bool first_will_do) {
    if (half.is_virtual() || !file_->refined(half.half.diamond)) return std::max(floor, sagitta_error(half));
    const auto vertices = positions_(half.half);
    Search s{measure, file_->summary(half.half).delta, floor, first_will_do,
             false,   {half.half, *vertices, cells_}};
    search(s, half.half);
    return s.best;
}

// Of the samples below `half`, a part of the patch: as they are seen, their distance from the patch is at
// most its delta.
double ExactError::bound_below(const Search& s, const Half& half) {
    const HalfVolume around = volume({half, half}, survey_.rounding());
    if (visibility_.cull(around) != Culled::none) return 0;
    HalfVolume wider = around;  // with the patch's points in it
    wider.slack += s.delta;
    return visibility_.screen_error(wider, s.delta);
}

void ExactError::search(Search& s, const Half& half) {
    if (s.found && s.first_will_do) return;
    if (!refined({half, half})) return look_at_samples(s, half);
    const std::array<Half, 2> children = child_halves(half);
    const std::array<double, 2> bounds{bound_below(s, children[0]), bound_below(s, children[1])};
    const std::size_t first = bounds[0] >= bounds[1] ? 0 : 1;
    for (const std::size_t k : {first, 1 - first})
        if (bounds[k] > s.best) search(s, children[k]);
}

void ExactError::look_at_samples(Search& s, const Half& leaf) {
    const View& view = visibility_.view();
    const double f = view.focal_pixels();
    const auto samples = positions_(leaf);
    const FlatPatch::Within flat(s.flat, leaf);
    std::size_t k = 0;
    for (int r = 0; r <= cells_; ++r)
        for (int c = 0; c <= r; ++c, ++k) {
            const Vec3 x = view.to_screen_axes((*samples)[k]);
            if (!(x[2] > 0) || std::abs(x[0]) > x[2] * view.tan_x() || std::abs(x[1]) > x[2] * view.tan_y())
                continue;
            const Vec3 point = flat.at(r, c);
            double error = 0;
            if (s.measure == Measure::distance) {
                error = f * length(subtract(point, (*samples)[k])) * length(x) / (x[2] * x[2]);
            } else {
                const Vec3 y = view.to_screen_axes(point);
                error = f * std::hypot(y[0] / y[2] - x[0] / x[2], y[1] / y[2] - x[1] / x[2]);
            }
            if (error > s.best) {
                s.best = error;
                s.found = true;
                if (s.first_will_do) return;
            }
        }
}

// Of a leaf, or of a part of one, where S is linear over the leaf's triangles.
const HalfRange& ExactError::range_of(const FreeHalf& half) {
    const auto [at, is_new] = ranges_.try_emplace(half.half);
    if (!is_new) return at->second;
    const auto heights = positions_.surface().heights(half.of_file.diamond);
    const HalfFrame leaf = half_frame(half.of_file, cells_), frame = half_frame(half.half, cells_);
    std::vector<double> h;
    for (int r = 0; r <= cells_; ++r)
        for (int c = 0; c <= r; ++c) {
            const auto place = index_of(leaf, half.half.side == 0 ? frame.vertex(r, c) : frame.vertex(c, r));
            const TriangleWeights w = triangle_weights(place[0], place[1], cells_);
            double sum = 0;
            for (std::size_t k = 0; k < 3; ++k)
                if (w.weight[k] > 0) sum += w.weight[k] * heights->at(w.vertex[k][0], w.vertex[k][1]);
            h.push_back(sum * file_->header().quantum);
        }
    HalfRange range{*std::min_element(h.begin(), h.end()), *std::max_element(h.begin(), h.end()), 0};
    for (const auto& t : half_triangles(half.half.side, cells_)) {
        const auto [low, high] = std::minmax({h[t[0]], h[t[1]], h[t[2]]});
        range.triangle_range = std::max(range.triangle_range, high - low);
    }
    return at->second = range;
}

// What the cut goes by there: the summary, or the half's own heights where these say less.
double ExactError::sagitta_error(const FreeHalf& half) {
    const HalfVolume around = volume(half, survey_.rounding());
    if (culled(half)) return 0;
    const double own = visibility_.screen_error(
        around, leaf_delta(body_, half.half, range_of(half), cells_) + survey_.rounding());
    if (half.is_virtual()) return own;
    const HalfBounds stored = survey_.by_summary(half.half, false);
    return std::min(own, visibility_.screen_error(stored.volume, stored.delta));
}

bool ExactError::culled(const FreeHalf& half) {
    if (visibility_.cull(volume(half, survey_.rounding())) != Culled::none) return true;
    return !half.is_virtual() &&
           visibility_.cull(survey_.by_summary(half.half, false).volume) != Culled::none;
}

}  // namespace carat::bench
