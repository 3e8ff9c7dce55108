// Positions of the vertices of halves, and points of the flat patches between them.
#pragma once

#include <array>
#include <list>
#include <memory>
#include <unordered_map>
#include <vector>

#include "carat/codec/surface.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/vector.hpp"

namespace carat::bench {

// Vertex positions of halves, with a cache.
class HalfPositions {
  public:
    explicit HalfPositions(const std::shared_ptr<const Repository>& file);
    // Indexed by half_vertex_index(), metres. Valid until the next call but one.
    std::shared_ptr<const std::vector<Vec3>> operator()(const Half& half);
    const Surface& surface() const { return surface_; }

  private:
    using Entry = std::pair<Half, std::shared_ptr<const std::vector<Vec3>>>;
    Surface surface_;
    Ellipsoid body_;
    std::list<Entry> entries_;  // most recently used first
    std::unordered_map<Half, std::list<Entry>::iterator, HalfHash> by_half_;
};

// A lattice offset in steps of a frame, whose axes are orthogonal.
std::array<double, 2> steps_of(const HalfFrame& frame, const LatticeVector& offset);

// The points of a half's flat patch at the places of the vertices of a half within it.
class FlatPatch {
  public:
    // positions: those of the half's vertices, kept by reference.
    FlatPatch(const Half& half, const std::vector<Vec3>& positions, int cells)
        : frame_(half_frame(half, cells)), positions_(positions), cells_(cells) {}

    class Within {
      public:
        Within(const FlatPatch& patch, const Half& part);
        // Row r and column c as in half_vertex_index() of the part.
        Vec3 at(int r, int c) const;

      private:
        const FlatPatch& patch_;
        int side_;
        std::array<double, 2> origin_, of_i_, of_j_;
    };

  private:
    HalfFrame frame_;
    const std::vector<Vec3>& positions_;
    int cells_;
};

}  // namespace carat::bench
