// The tangents of a half's lattice coordinates.
#pragma once

#include <array>
#include <cstddef>
#include <span>

#include "carat/globe/diamond.hpp"

namespace carat {

// The tangents of a half's vertices, one lattice coordinate at a time: that of vertex (r, c) in storage order
// is at(r)[c], or *at(r) for all c where the coordinate is the same along a row.
class TangentTable {
  public:
    // The frame of a half with that side and that many cells.
    TangentTable(const HalfFrame& frame, int side, int axis, int cells);

    const double* at(int r) const { return tangents_.data() + first_ + r * per_row_; }
    bool along_row() const { return along_row_; }
    double value(int r, int c) const { return at(r)[along_row_ ? c : 0]; }

  private:
    std::array<double, 2 * 128 + 1 + 31> tangents_;  // padded by a vector's width
    std::ptrdiff_t first_ = 0, per_row_ = 0;
    bool along_row_ = false;
};

// tangents[k] = vertex_tangent(tangents[k]) for a count that is a multiple of 16.
void tangents_in_place(std::span<double> tangents);

}  // namespace carat
