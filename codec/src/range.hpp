// The range coder: tokens of a matrix of residual indices by static-context rANS (Duda 2013), interleaved
// over 1 to 32 states. docs/format.md, "Range code".
//
// Cells are coded in two passes, like the colours of a chess board: those with i + j even in contexts of the
// activity of the matrix that predicts them, then the others with their neighbours' indices besides. So all
// contexts of a pass are known before it, and nothing depends on the symbol before. Everything but the states
// themselves is computed for whole rows at once.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "bits.hpp"
#include "carat/codec/coding.hpp"
#include "kernels.hpp"
#include "range_model.hpp"

namespace carat {

// What contexts are made of, known to encoder and decoder before the indices: `known` is the m x m matrix
// that predicts, rows <= m - 1 the side of the matrix of indices.
struct RangeInput {
    const std::int32_t* known;
    int m, rows;
    std::int32_t radius;                   // quantiser's
    Activity activity = Activity::window;  // what an encoder takes; a decoder is told by the code
};

// Reused between calls; one per thread.
struct RangeScratch {
    ActivityScratch activity_scratch;
    std::vector<std::uint32_t> activity;                      // (m-1) x (m-1)
    std::array<std::vector<std::uint32_t>, 2> pass_activity;  // pass matrices (range_kernels.hpp)
    std::array<std::vector<std::uint8_t>, 2> context, token;  // the same; while coding without gaps
    std::vector<std::uint8_t> near, magnitude, cells, cost_context;
    std::vector<std::uint16_t> big;
    std::vector<std::byte> code;    // padded
    std::vector<std::uint8_t> raw;  // payload of the states, raw bits, padding
    std::vector<std::uint16_t> words;
    BitWriter raw_bits, state_bits;
    std::vector<std::byte> matrix, blob;  // for whoever puts matrices together
};

// Appends the coded matrix (rows x rows). Counts tokens into `statistics` if not null.
void range_encode(const RangeTables::Model& model, const RangeInput& input,
                  std::span<const std::int32_t> index, RangeScratch& scratch, RangeStatistics* statistics,
                  std::vector<std::byte>& out);

// Compares matrices of indices, and activities, where the same `known` predicts: prepare once an activity,
// then an estimate in 1/256 bit of what range_encode would append for each, from a part of the rows. rows = m
// - 1.
void range_prepare_cost(const RangeInput& input, RangeScratch& scratch);
std::uint64_t range_cost(const RangeTables::Model& model, std::span<const std::int32_t> index, int rows,
                         const RangeScratch& scratch);

// bytes: all that range_encode appended. Throws Error(corrupt|truncated).
void range_decode(const RangeTables::Model& model, const RangeInput& input, std::span<const std::byte> bytes,
                  RangeScratch& scratch, std::span<std::int32_t> index);

}  // namespace carat
