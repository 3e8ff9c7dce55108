// Inner loops of the gamma coder over runs of codes, vectorised where the processor can.
#pragma once

#include <cstddef>
#include <cstdint>

namespace carat::kernel {

// A bit string, bit 0 of each byte first, with at least 64 readable bytes of zeros after its end.
struct BitRun {
    const std::byte* bytes;
    std::size_t at, end;  // bits; at <= end
};
inline constexpr std::size_t kBitRunPadding = 64;

enum class RunEnd : std::uint8_t { good, truncated, corrupt };

// Places of the next `count` ones of the run, from `at` on, modulo 256; ends: room for count + 64. Moves
// run.at behind the last. corrupt: 64 or more zeros in a row, or so many that an aligned word is zero.
RunEnd ones(BitRun& run, std::size_t count, std::uint8_t* ends);

// Values of codes whose lengths' ones are at ends[0 .. count), the one before at ends[-1] modulo 256, from
// suffixes at run.at on. values: room for count + 8. corrupt: a code above 2^32.
RunEnd suffixes(BitRun& run, std::size_t count, const std::uint8_t* ends, std::int32_t* values);

// Bits of the codes of all values: the sum of 2 floor(log2(zigzag + 1)) + 1.
std::uint64_t code_bits(const std::int32_t* values, std::size_t count);

// Bit j % 64 of word j / 64: whether values[j] is not zero; ceil(count / 64) words.
void nonzero_bits(const std::int32_t* values, std::size_t count, std::uint64_t* words);

}  // namespace carat::kernel
