#include "half_bounds.hpp"

#include <numbers>

#include "carat/globe/bounds.hpp"
#include "carat/render/cut.hpp"
#include "carat/render/vertex_position.hpp"

namespace carat {

HalfSurvey::HalfSurvey(const Repository& repository, const Ellipsoid& body, const ColourRepository* colour,
                       const Detail* detail)
    : repository_(repository),
      colour_(colour),
      detail_(detail),
      body_(body),
      cells_(repository.header().cells()),
      quantum_(repository.header().quantum),
      rounding_(length_unit(body_) * (std::numbers::sqrt3 / 2 + kPositionRounding)) {}

double HalfSurvey::spacing(const Half& half, bool has_finer) const {
    if (!has_finer && (colour_ == nullptr || !colour_->refined(half.diamond))) return 0;
    return sample_spacing(body_, half.diamond, cells_);
}

// A leaf whose detail may show is left to its own heights.
HalfBounds HalfSurvey::by_summary(const HalfShape& shape, const Half& half, bool refined_by_file) const {
    const HalfSummary s = repository_.summary(half);
    const double beyond = detail_ == nullptr ? 0 : detail_->bound_beneath(repository_, half);
    return {shape.volume(s.min_height - beyond, s.max_height + beyond, rounding_),
            s.delta + beyond + rounding_, spacing(half, refined_by_file || beyond > 0)};
}

// Detail moves points along unit normals, on top of what the flat triangles miss.
HalfBounds HalfSurvey::by_heights(const HalfShape& shape, const Half& half,
                                  const HalfHeights& heights) const {
    const HalfRange range = half_range(heights, cells_, quantum_);
    const int level = detail_ == nullptr ? 0 : half.diamond.level();
    const double beyond = detail_ == nullptr ? 0 : detail_->bound(level, heights);
    return {shape.volume(range.min - beyond, range.max + beyond, rounding_),
            leaf_delta(shape.curvature(cells_), range) + beyond + rounding_,
            spacing(half, detail_ != nullptr && detail_->shows(level, heights))};
}

HalfBounds HalfSurvey::by_summary(const Half& half, bool refined_by_file) const {
    return by_summary(HalfShape(body_, half), half, refined_by_file);
}

HalfBounds HalfSurvey::by_heights(const Half& half, const HalfHeights& heights) const {
    return by_heights(HalfShape(body_, half), half, heights);
}

HalfFacts HalfSurvey::facts(const Half& half, bool in_file, bool refined_by_file,
                            const HalfHeights& heights) const {
    HalfFacts facts;
    const HalfShape shape(body_, half);
    if (in_file) facts.stored = by_summary(shape, half, refined_by_file);
    if (!refined_by_file) facts.own = by_heights(shape, half, heights);
    return facts;
}

Judgement judge(const Visibility& visibility, double threshold, double spacing, const HalfBounds& bounds) {
    Judgement j;
    j.culled = visibility.cull(bounds.volume);
    if (j.culled != Culled::none) return j;
    j.error = visibility.screen_error(bounds.volume, bounds.delta);
    j.demands = j.error > threshold || (spacing > 0 && bounds.spacing > 0 &&
                                        visibility.screen_spacing(bounds.volume, bounds.spacing) > spacing);
    return j;
}

Judgement judge(const Visibility& visibility, double threshold, double spacing, const HalfFacts& facts,
                bool may_refine) {
    if (facts.stored) {
        const Judgement j = judge(visibility, threshold, spacing, *facts.stored);
        if (!j.demands || !facts.own) return j;
    }
    Judgement j = judge(visibility, threshold, spacing, *facts.own);
    j.demands = j.demands && may_refine;
    return j;
}

}  // namespace carat
