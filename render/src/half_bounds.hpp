// What is known of a half whatever the view, and how a view judges it.
#pragma once

#include <optional>

#include "carat/codec/colour.hpp"
#include "carat/codec/repository.hpp"
#include "carat/render/detail.hpp"
#include "carat/render/half_heights.hpp"
#include "carat/render/visibility.hpp"

namespace carat {

// True bounds of the flat patch of a half and of the surface beneath it, S or S with detail; metres.
struct HalfBounds {
    HalfVolume volume;
    double delta = 0;    // of the distance between patch and S, the rounding of vertices included
    double spacing = 0;  // of samples, in the mean; 0 if neither the file nor its colours have finer ones
};

struct HalfFacts {
    std::optional<HalfBounds> stored;  // by the file's summary: halves of the file
    std::optional<HalfBounds> own;     // by its own heights: halves that the file does not refine
};

struct Judgement {
    Culled culled = Culled::none;
    double error = 0;  // pixels; 0 if culled
    bool demands = false;
};

// Makes HalfFacts of one file. Thread-safe.
class HalfSurvey {
  public:
    // colour, if not null, has samples of its own: bounds have their spacing where it is finer than the file.
    // detail, if not null, is part of the surface.
    HalfSurvey(const Repository& repository, const Ellipsoid& body, const ColourRepository* colour = nullptr,
               const Detail* detail = nullptr);

    HalfBounds by_summary(const Half& half, bool refined_by_file) const;
    HalfBounds by_heights(const Half& half, const HalfHeights& heights) const;
    HalfFacts facts(const Half& half, bool in_file, bool refined_by_file, const HalfHeights& heights) const;

    // Metres: how far a vertex in whole length units may lie from its point of S.
    double rounding() const { return rounding_; }

  private:
    double spacing(const Half& half, bool has_finer) const;
    HalfBounds by_summary(const HalfShape& shape, const Half& half, bool refined_by_file) const;
    HalfBounds by_heights(const HalfShape& shape, const Half& half, const HalfHeights& heights) const;

    const Repository& repository_;
    const ColourRepository* colour_;
    const Detail* detail_;
    Ellipsoid body_;
    int cells_;
    double quantum_, rounding_;
};

// threshold, spacing: pixels.
Judgement judge(const Visibility& visibility, double threshold, double spacing, const HalfBounds& bounds);
// may_refine: the half is above the deepest level.
Judgement judge(const Visibility& visibility, double threshold, double spacing, const HalfFacts& facts,
                bool may_refine);

}  // namespace carat
