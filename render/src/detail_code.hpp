// How roughness is written: at each vertex of a half an amplitude and its decay, in one int32.
//
//   amplitude   high 16 bits, signed: log2 of the greatest residual of the half's own refinement, quanta, in
//               1/256; below kLeastAmplitude: none
//   decay       low 16 bits: by how much it falls a level, in 1/256
//
// log2 and its inverse have a mantissa that is linear in the fraction: 2^e (1 + f) <-> e + f, exact inverses
// of each other, within 6 % of the true power.
#pragma once

#include <bit>
#include <cmath>
#include <cstdint>

namespace carat {

inline constexpr int kOctave = 256;
inline constexpr int kNoAmplitude = -100 * kOctave;
inline constexpr int kLeastAmplitude = -14 * kOctave, kGreatestAmplitude = 20 * kOctave;
inline constexpr int kDefaultDecay = 102;                     // Hurst exponent 0.8
inline constexpr int kLeastDecay = 77, kGreatestDecay = 192;  // 0.6 and 1.5; a level is half an octave

constexpr std::int32_t pack_roughness(int amplitude, int decay) { return amplitude * 65536 + decay; }
constexpr int amplitude_of(std::int32_t packed) { return packed >> 16; }
constexpr int decay_of(std::int32_t packed) { return packed & 0xFFFF; }

// Of x > 0, rounded down.
constexpr int linear_log2(std::uint64_t x) {
    const int e = 63 - std::countl_zero(x);
    return e * kOctave + static_cast<int>((x << (63 - e) >> 55) & 255);
}
inline int linear_log2(double x) {
    int e = 0;
    const double m = std::frexp(x, &e);  // [0.5, 1)
    return (e - 1) * kOctave + static_cast<int>(std::floor((2 * m - 1) * kOctave));
}
inline double linear_exp2(int log) { return std::ldexp(kOctave + (log & 255), (log >> 8) - 8); }

}  // namespace carat
