// The exact error of a patch on the screen, found among all samples of the file beneath it.
#pragma once

#include <memory>
#include <unordered_map>

#include "carat/render/visibility.hpp"
#include "flat_patch.hpp"
#include "free_cut.hpp"
#include "half_bounds.hpp"

namespace carat::bench {

enum class Measure : std::uint8_t {
    distance,  // f |X - Y| sec(theta) / z: what Visibility::screen_error() bounds
    shift,     // of Y against X on the screen
};

// Of one view.
class ExactError {
  public:
    ExactError(const std::shared_ptr<const Repository>& file, const Visibility& visibility,
               HalfPositions& positions);

    // The greatest error, pixels, above `floor`, or `floor` if there is none; any above it if first_will_do.
    // Halves that are no patches of the file, and its leaves: a bound of the sagitta.
    double greatest(const FreeHalf& half, Measure measure, double floor, bool first_will_do);
    bool culled(const FreeHalf& half);
    bool refined(const FreeHalf& half) const;  // by the file
    HalfVolume volume(const FreeHalf& half, double margin);

  private:
    struct Search {
        Measure measure;
        double delta, best;
        bool first_will_do;
        bool found = false;
        FlatPatch flat;
    };
    double bound_below(const Search& s, const Half& half);
    void search(Search& s, const Half& half);
    void look_at_samples(Search& s, const Half& leaf);
    const HalfRange& range_of(const FreeHalf& half);
    double sagitta_error(const FreeHalf& half);

    const std::shared_ptr<const Repository> file_;
    const Visibility& visibility_;
    HalfPositions& positions_;
    Ellipsoid body_;
    int cells_;
    HalfSurvey survey_;
    std::unordered_map<Half, HalfRange, HalfHash> ranges_;  // of leaves and their parts
};

}  // namespace carat::bench
