// Procedural detail: relief below the file's leaves, from a hash of lattice point and seed.
//
// Where the file ends, a diamond is refined virtually: V = P, C = the midpoint of the cell's diagonal. Detail
// adds to each C a residual r, |r| <= a, that depends on the cell's four corners and on a hash of C's lattice
// point, its level and the seed:
//
//   r = clamp((mean of the four corners - midpoint) + 0.7 a u, -a, a),  u uniform in [-1, 1)
//
// C lies inside one diamond, so it is made once, whoever asks: no cracks, no seams, the same in any order.
// Everything that decides is integer arithmetic. Samples of the file never change.
//
//   uniform   a = amplitude * spacing of the level: C-BDAM (Gobbetti et al. 2006), section on synthesis
//   natural   a per vertex, from the relief around it (detail_roughness.hpp): amplitude and decay continue
//             the variances of the last real levels; level ground stays level
//
// Limits, all true bounds: a is at most tan(slope) times half the cell's diagonal; natural detail beneath a
// half of the file strays from S by at most kShare delta(parent of the leaf), and by a sixteenth of the
// file's whole relief; uniform detail by 1/4096 of the semi-axis.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "carat/codec/repository.hpp"
#include "carat/render/half_heights.hpp"

namespace carat {

struct DetailOptions {
    std::uint64_t seed = 1;
    std::optional<double> amplitude;  // natural: a factor, default 1; uniform: metres a metre, default 0.05
    double to = 0.1;                  // metres: the spacing of samples that needs no more detail
    double slope = 35;                // degrees, (0, 80]
    bool uniform = false;

    // "seed=7,amplitude=0.5,to=1,slope=30,mode=uniform", any of them; "" is the default. Throws Error(usage).
    static DetailOptions parse(const std::string& text);
};

// Of one file. Immutable, thread-safe.
class Detail {
  public:
    // Throws Error(usage) for options out of range.
    Detail(const RepositoryHeader& header, const DetailOptions& options);

    const DetailOptions& options() const { return options_; }
    // Diamonds of this level and below have no residuals.
    int end_level() const { return end_level_; }
    // Mean spacing of the samples of a level, metres: sqrt(area of the body / cells of the level).
    double spacing(int level) const { return spacings_[static_cast<std::size_t>(level)]; }
    // Upper bound, metres, of the distance of detail from S anywhere in the file.
    double greatest() const { return greatest_; }

    // Gives a half of the file that is not refined by it (a leaf) the roughness at its vertices. Reads the
    // summary of the half above; throws what that throws.
    void begin(const Repository& repository, const Half& leaf, HalfHeights& heights) const;
    // V and C of a diamond of that level with detail, in memory that is reused. Precondition: both halves
    // have been given roughness, or come from here.
    void refine(DiamondId diamond, int level, const HalfHeights& half0, const HalfHeights& half1,
                VirtualHeights& out) const;

    // Upper bounds, metres, of the height between the flat triangles of a half and all detail beneath it,
    // from its own roughness; and between S and detail beneath a half of the file, from summaries.
    double bound(int level, const HalfHeights& heights) const;
    double bound_beneath(const Repository& repository, const Half& half) const;
    // Whether detail beneath changes slopes by more than shading shows, 1/256.
    bool shows(int level, const HalfHeights& heights) const;

  private:
    double sum_of(int level, int amplitude, int decay) const;
    double share_of_delta(double delta) const;
    double look_beneath(const Repository& repository, const Half& half, int level, double parent_delta,
                        int levels) const;

    DetailOptions options_;
    int cells_ = 0, end_level_ = 0;
    double quantum_ = 0, greatest_ = 0, factor_ = 1;
    std::array<double, 52> spacings_{};
    std::array<std::int32_t, 52> caps_{};  // of amplitudes, log2 of quanta in 1/256
};

}  // namespace carat
