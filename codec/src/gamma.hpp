// The gamma coder: a zero-quadtree whose leaves are Elias-gamma coded (C-BDAM 2006, section 5), laid out in
// three runs so that a decoder works on many values at once. docs/format.md, "Zero-quadtree".
//
//   flags       one bit: any value not zero; then by size, from the whole square down to twice the leaf size,
//               for every square so far not zero four flags of its quadrants (the fourth left out, and 1, if
//               the other three are 0)
//   lengths     for every value of every leaf: floor(log2 x) zero bits and a one; x = zigzag + 1
//   suffixes    for every value, in the same order: the low floor(log2 x) bits of x
//
// Squares are in Z-order, (low i, low j), (low i, high j), (high i, low j), (high i, high j); values of a
// leaf in rows. A matrix smaller than side x side (the residuals of interior vertices) is extended with
// absent values, which write nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "bits.hpp"

namespace carat {

// Writes matrices of a blob, one after another. One per thread; its memory is used again for the next blob.
class GammaWriter {
  public:
    void open() { bits_.clear(); }
    // values: rows x rows, side/2 < rows <= side, side = 2^k >= leaf_size, k <= 7.
    void add(std::span<const std::int32_t> values, int rows, int side, int leaf_size);
    // The blob; valid until the writer is used again.
    std::span<const std::byte> finish() { return bits_.finished(); }
    // Bits add() would write.
    std::uint64_t cost(std::span<const std::int32_t> values, int rows, int side, int leaf_size);

  private:
    BitWriter bits_;
    std::vector<std::uint16_t> leaves_, finer_;  // Z-order numbers
    std::vector<std::int32_t> sequence_;         // values of the leaves
};

// Reads matrices of a blob, one after another. One per thread; its memory is used again for the next blob.
class GammaReader {
  public:
    void open(std::span<const std::byte> blob);
    // Throws Error(corrupt) for codes no encoder writes, Error(truncated) past the end.
    void read(int rows, int side, int leaf_size, std::span<std::int32_t> values);
    // The same for a few values among many: adds step times each to what stands in `values`, modulo 2^32.
    void add(int rows, int side, int leaf_size, std::int32_t step, std::span<std::int32_t> values);
    // Throws Error(corrupt) unless all but the zero padding of the last byte was read.
    void finish() const;

  private:
    std::size_t read_leaves(int side, int leaf_size);
    void read_sequence(int rows, int side, int leaf_size);
    std::uint64_t peek() const;
    void demand_inside() const;

    std::vector<std::byte> bytes_;  // the blob and kPadding zeros
    std::size_t bits_ = 0, at_ = 0;
    std::vector<std::uint16_t> leaves_, parents_;  // Z-order numbers
    std::vector<std::uint8_t> ends_;               // of the lengths, bit positions modulo 256
    std::vector<std::int32_t> sequence_;           // values of all leaves
};

}  // namespace carat
