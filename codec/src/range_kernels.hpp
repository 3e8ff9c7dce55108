// Inner loops of the range coder over the two passes of a matrix, vectorised where the processor can. Pass
// matrices have `rows` rows of `pitch` = ceil(rows / 2) elements: element k of row i of pass p is the cell in
// column 2k + ((i + p) mod 2). Where rows is odd the last element of every other row is a gap.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "range_model.hpp"

namespace carat {

inline constexpr int kMostLog2States = 5, kMostStates = 1 << kMostLog2States;

// The states of a code and the words still to come: next <= end, and kStatePadding readable bytes from end
// on.
inline constexpr std::size_t kStatePadding = 4 * kMostStates;
struct StateRun {
    std::array<std::uint32_t, kMostStates> x{};
    const std::byte *next = nullptr, *end = nullptr;
};

namespace kernel {

// Rows of cells, `stride` apart, into the two passes; gaps get `filling`.
void split_passes(const std::uint32_t* cells, std::size_t stride, int rows, std::uint32_t filling,
                  std::uint32_t* pass0, std::uint32_t* pass1);
void split_passes(const std::uint8_t* cells, std::size_t stride, int rows, std::uint8_t* pass0,
                  std::uint8_t* pass1);
// The reverse; cells: rows x rows.
void merge_passes(const std::uint8_t* pass0, const std::uint8_t* pass1, int rows, std::uint8_t* cells);

// near, of pass 1: the sum of the magnitudes (carat::seen_magnitude) of a cell's neighbours in pass 0, at
// most 4 * 63. Gaps of `token`, of pass 0, must be 0. scratch: used again.
void neighbour_magnitudes(const std::uint8_t* token, int rows, std::vector<std::uint8_t>& scratch,
                          std::uint8_t* near);

// Decodes `count` tokens in contexts (pass included) with `states` = 2^k states in turn. False if words are
// missing: decoding then went on with bytes from after the end. token: room for count.
bool decode_tokens(const RangeTables::Model::Buckets& buckets, int states, StateRun& run,
                   const std::uint8_t* context, std::size_t count, std::uint8_t* token);

// Numbers of tokens that are not 0; those from kDirectTokens on go to `big`, room for count.
struct TokenCensus {
    std::size_t nonzero, big;
};
TokenCensus take_census(const std::uint8_t* token, std::size_t count, std::uint16_t* big);

// index[k] = token[k], negated if the next raw bit says so; a token of 0 has none. raw: 8 readable bytes
// after the bits.
void apply_signs(const std::uint8_t* token, std::size_t count, const std::uint8_t* raw, std::int32_t* index);

// Tokens of indices (carat::token_of).
void make_tokens(const std::int32_t* index, std::size_t count, std::uint8_t* token);

}  // namespace kernel
}  // namespace carat
