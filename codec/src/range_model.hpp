// The model of the range coder: how residual indices become tokens, which context a token has, and the static
// frequencies of tokens by context. docs/format.md, "Range code".
//
//   token t     of an index e: |e| itself below 16; then four tokens an octave, the octave's remaining bits
//               raw; 63: 32 raw bits. A token other than 0 has a sign besides, raw too
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

inline constexpr int kTokens = 64, kEscape = 63, kDirectTokens = 16;
inline constexpr int kPassContexts = 64, kContexts = 2 * kPassContexts;
inline constexpr int kFrequencyBits = 12, kFrequencySum = 1 << kFrequencyBits;
inline constexpr int kBucketBits = 6, kBucketSize = 1 << kBucketBits;  // alias table: 64 buckets of 64 slots

constexpr std::uint32_t magnitude_of(std::int32_t e) {
    const auto u = static_cast<std::uint32_t>(e);
    return e < 0 ? 0u - u : u;
}
// e of a magnitude (2^31 is the least int32) and a sign bit.
constexpr std::int32_t with_sign(std::uint32_t magnitude, unsigned negative) {
    return static_cast<std::int32_t>(negative != 0 ? 0u - magnitude : magnitude);
}

// Raw bits of a token's magnitude; the sign is counted apart.
constexpr int raw_bits(int token) {
    return token < kDirectTokens ? 0 : token == kEscape ? 32 : (token - kDirectTokens) / 4 + 2;
}
// Magnitude of a token whose raw bits are zero (escape: 0).
constexpr std::uint32_t token_base(int token) {
    if (token < kDirectTokens) return static_cast<std::uint32_t>(token);
    if (token == kEscape) return 0;
    const int k = token - kDirectTokens;  // quarter-octaves above 16
    return (4u + static_cast<std::uint32_t>(k & 3)) << (k / 4 + 2);
}
constexpr int token_of(std::uint32_t magnitude) {
    if (magnitude < kDirectTokens) return static_cast<int>(magnitude);
    const int e = static_cast<int>(std::bit_width(magnitude)) - 1;
    const int token = kDirectTokens + 4 * (e - 4) + static_cast<int>((magnitude >> (e - 2)) & 3);
    return token < kEscape ? token : kEscape;
}
static_assert(token_of(16) == 16 && token_base(16) == 16 && raw_bits(16) == 2);
static_assert(token_of(19) == 16 && token_of(20) == 17 && token_base(17) == 20);
static_assert(token_of(32) == 20 && token_base(20) == 32 && raw_bits(20) == 3);
static_assert(token_of((1u << 15) + (3u << 13) - 1) == 62 && token_of((1u << 15) + (3u << 13)) == kEscape);
static_assert(token_of(1u << 31) == kEscape && with_sign(1u << 31, 1) == -2147483647 - 1);

// Magnitude as contexts of neighbours see it: the token's least, at most 63.
inline constexpr int kMostMagnitude = 63;
constexpr std::uint8_t seen_magnitude(int token) {
    if (token == kEscape || token_base(token) > kMostMagnitude) return kMostMagnitude;
    return static_cast<std::uint8_t>(token_base(token));
}

struct RangeTables::Model {
    using Frequencies = std::array<std::array<std::uint16_t, kTokens>, kContexts>;

    // Each context sums to kFrequencySum and has a non-zero escape.
    explicit Model(const Frequencies& f);

    // Alias method (Walker 1974): slot x of 4096 lies in bucket x / 64 at y = x mod 64; below the cutoff it
    // is number y of the bucket's own token, else number y + first of its alias.
    struct Buckets {
        std::vector<std::uint32_t> split;  // own frequency | alias's << 12 | cutoff << 24
        std::vector<std::uint32_t> alias;  // token | first << 6, first modulo 2^26 for it may be negative
    };
    Buckets buckets;  // context * 64 + bucket
    Frequencies frequency;

    // For encoders, made when first asked.
    struct Encoder {
        std::vector<std::uint16_t> slot;   // context * 4096 + begin + number within the token
        std::vector<std::uint16_t> begin;  // context * 64 + token
        std::vector<std::uint16_t> cost;   // context * 64 + token, sign and raw bits included, 1/256 bit
    };
    const Encoder& encoder() const;

  private:
    void make_aliases(int context);
    void make_encoder() const;

    mutable std::once_flag made_;
    mutable Encoder encoder_;
};

}  // namespace carat
