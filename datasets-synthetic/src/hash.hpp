// Integer hashing for everything random in this module: the same numbers from every compiler.
#pragma once

#include <cstdint>

namespace carat::synth {

/// Mixes 64 bits so that each input bit reaches every output bit (two multiply-xorshift rounds).
constexpr std::uint64_t mix(std::uint64_t x) noexcept {
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93ULL;
    x ^= x >> 32;
    x *= 0xd6e8feb86659fd93ULL;
    return x ^ (x >> 32);
}

/// An independent seed for the stream `stream` of `seed`.
constexpr std::uint64_t stream_seed(std::uint64_t seed, std::uint64_t stream) noexcept {
    return mix(seed * 0x9e3779b97f4a7c15ULL + mix(stream + 0x632be59bd9b4e019ULL));
}

inline constexpr std::uint64_t kLatticeX = 0x9e3779b97f4a7c15ULL;
inline constexpr std::uint64_t kLatticeY = 0xc2b2ae3d27d4eb4fULL;
inline constexpr std::uint64_t kLatticeZ = 0x165667b19e3779f9ULL;

/// Largest integer not above x, |x| < 2^53. (std::floor is a function call without SSE4.1.)
constexpr std::int64_t floor_int(double x) noexcept {
    const auto i = static_cast<std::int64_t>(x);
    return i - (static_cast<double>(i) > x);
}

/// Hash of an integer lattice point.
constexpr std::uint64_t lattice_hash(std::int64_t x, std::int64_t y, std::int64_t z,
                                     std::uint64_t seed) noexcept {
    return mix(seed + static_cast<std::uint64_t>(x) * kLatticeX + static_cast<std::uint64_t>(y) * kLatticeY +
               static_cast<std::uint64_t>(z) * kLatticeZ);
}

/// 21 bits of `h` starting at `shift` as a multiple of 2^-20 in [-1, 1).
constexpr double signed_unit(std::uint64_t h, int shift) noexcept {
    return static_cast<double>(static_cast<std::int32_t>((h >> shift) & 0x1fffff) - 0x100000) * 0x1p-20;
}

/// 21 bits of `h` starting at `shift` as a multiple of 2^-21 in [0, 1).
constexpr double unit(std::uint64_t h, int shift) noexcept {
    return static_cast<double>(static_cast<std::int32_t>((h >> shift) & 0x1fffff)) * 0x1p-21;
}

/// A sequence of random numbers, for the few that are drawn when a planet is made.
class Sequence {
  public:
    explicit constexpr Sequence(std::uint64_t seed) noexcept : seed_(seed) {}
    constexpr std::uint64_t bits() noexcept { return stream_seed(seed_, next_++); }
    /// Uniform in [0, 1), a multiple of 2^-53.
    constexpr double uniform() noexcept { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    constexpr double uniform(double lo, double hi) noexcept { return lo + (hi - lo) * uniform(); }

  private:
    std::uint64_t seed_;
    std::uint64_t next_ = 0;
};

}  // namespace carat::synth
