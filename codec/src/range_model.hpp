// The model of the range coder: how residual indices become tokens, which context a token has, and the static
// frequencies of tokens by context. docs/format.md, "Range code".
//
//   index e     zigzag: z = 2e (e >= 0) or -2e - 1
//   token t     z itself below 24; then two tokens an octave with the octave's remaining bits raw; 63: 32 raw
//   context     64 by activity (quarter octaves) x {first pass, second pass}
//   frequency   of 4096; token 63 never 0, so that every index can be written in every context
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <mutex>
#include <vector>

#include "carat/codec/coding.hpp"

namespace carat {

inline constexpr int kTokens = 64, kEscape = 63, kDirectTokens = 24;
inline constexpr int kPassContexts = 64, kContexts = 2 * kPassContexts;
inline constexpr int kFrequencyBits = 12, kFrequencySum = 1 << kFrequencyBits;
inline constexpr int kBucketBits = 6, kBucketSize = 1 << kBucketBits;  // alias table: 64 buckets of 64 slots

constexpr std::uint32_t zigzag(std::int32_t e) {
    return (static_cast<std::uint32_t>(e) << 1) ^ static_cast<std::uint32_t>(e >> 31);
}
constexpr std::int32_t unzigzag(std::uint32_t z) {
    return static_cast<std::int32_t>((z >> 1) ^ (0u - (z & 1u)));
}

// Raw bits that follow a token.
constexpr int raw_bits(int token) {
    return token < kDirectTokens ? 0 : token == kEscape ? 32 : (token - kDirectTokens + 1) / 2 + 3;
}
// z of a token whose raw bits are zero (escape: 0).
constexpr std::uint32_t token_base(int token) {
    if (token < kDirectTokens) return static_cast<std::uint32_t>(token);
    if (token == kEscape) return 0;
    const int k = token - kDirectTokens + 1;  // half-octaves above 16
    return (2u + static_cast<std::uint32_t>(k & 1)) << (k / 2 + 3);
}
constexpr int token_of(std::uint32_t z) {
    if (z < kDirectTokens) return static_cast<int>(z);
    const int e = static_cast<int>(std::bit_width(z)) - 1;
    const int token = kDirectTokens - 1 + 2 * (e - 4) + static_cast<int>((z >> (e - 1)) & 1);
    return token < kEscape ? token : kEscape;
}
static_assert(token_of(24) == 24 && token_base(24) == 24 && raw_bits(24) == 3);
static_assert(token_of(32) == 25 && token_base(25) == 32 && raw_bits(25) == 4);
static_assert(token_of(47) == 25 && token_of(48) == 26 && token_base(26) == 48 && raw_bits(26) == 4);
static_assert(token_of(0xFFFFFFFFu) == kEscape && token_of((1u << 23) + (1u << 22)) == 62);

// |index| as contexts of neighbours see it: the token's least, at most 63.
constexpr int kMostMagnitude = 63;
constexpr std::uint8_t token_magnitude(int token) {
    if (token == kEscape) return kMostMagnitude;
    const std::uint32_t m = (token_base(token) + 1) / 2;
    return static_cast<std::uint8_t>(m < kMostMagnitude ? m : kMostMagnitude);
}

struct RangeTables::Model {
    using Frequencies = std::array<std::array<std::uint16_t, kTokens>, kContexts>;

    // Each context sums to kFrequencySum and has a non-zero escape.
    explicit Model(const Frequencies& f);

    // Alias method (Walker 1974): slot x of 4096 lies in bucket x / 64 at x mod 64; below the cutoff it
    // belongs to the bucket's own token, else to its alias. Entries: token | frequency << 6 | offset << 18;
    // the slot's number within its token is (x mod 64 + offset) mod 4096.
    std::vector<std::uint8_t> cutoff;                   // context * 64 + bucket
    std::vector<std::array<std::uint32_t, 2>> entries;  // the same: own, alias
    Frequencies frequency;

    // For encoders, made when first asked.
    struct Encoder {
        std::vector<std::uint16_t> slot;   // context * 4096 + begin + number within the token
        std::vector<std::uint16_t> begin;  // context * 64 + token
        std::vector<std::uint16_t> cost;   // context * 64 + token, raw bits included, 1/256 bit
    };
    const Encoder& encoder() const;

  private:
    void make_aliases(int context);
    void make_encoder() const;

    mutable std::once_flag made_;
    mutable Encoder encoder_;
};

}  // namespace carat
