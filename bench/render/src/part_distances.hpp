// What a file could say better: the exact greatest distance between a flat patch and S, and that of each
// quarter of the patch. Where between the stored bound and the oracle of exact_error.hpp these would come,
// says what a finer delta, or four of them, would save.
#pragma once

#include <array>
#include <unordered_map>

#include "exact_error.hpp"

namespace carat::bench {

// Metres, of the quarters two levels down.
using QuarterDistances = std::array<double, 4>;

class PartDistances {
  public:
    PartDistances(const Repository& file, HalfPositions& positions) : file_(file), positions_(positions) {}

    // Precondition: a half that the file refines. Kept for other views.
    const QuarterDistances& operator()(const Half& half);

  private:
    // `part` lies `depth` levels below the patch, in quarter `quarter` if depth >= 2.
    void measure(const FlatPatch& flat, const Half& part, int depth, std::size_t quarter,
                 QuarterDistances& out);
    bool refined(const Half& half) const;

    const Repository& file_;
    HalfPositions& positions_;
    std::unordered_map<Half, QuarterDistances, HalfHash> known_;
};

enum class Parts : std::uint8_t { whole, quarters };

// Pixels: what Visibility::screen_error() makes of such distances instead of the stored delta, each at the
// nearest point of its part.
double bound_by_parts(const Repository& file, const Visibility& visibility, const Half& half, Parts parts,
                      double rounding, PartDistances& distances);

}  // namespace carat::bench
