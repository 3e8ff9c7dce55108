// Matrices of heights in temporary files: differences to the neighbour before, in 16 bits where these
// suffice, else the heights in 32 bits. Heights of a diamond spread over more than 16 bits in mountains,
// their differences hardly ever do.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace carat {

namespace packed {

inline constexpr std::uint32_t kHalf = 1u << 15;

// Difference to the value before in the row, at the start of a row to the value above, mod 2^32.
inline std::uint32_t difference(const std::int32_t* values, std::size_t k, std::size_t before) {
    return static_cast<std::uint32_t>(values[k]) - static_cast<std::uint32_t>(values[k - before]);
}

inline bool small_differences(std::span<const std::int32_t> values, std::size_t row) {
    std::uint32_t wide = 0;
    const auto look = [&](std::size_t k, std::size_t before) {
        wide |= (difference(values.data(), k, before) + kHalf) >> 16;
    };
    for (std::size_t start = 0; start < values.size(); start += row) {
        if (start > 0) look(start, row);
        for (std::size_t k = start + 1; k < start + row; ++k) look(k, 1);
    }
    return wide == 0;
}

}  // namespace packed

// Appends a matrix of rows of the given length; the reader must know both. values: whole rows.
inline void pack(std::span<const std::int32_t> values, std::size_t row, std::vector<std::byte>& out) {
    const bool small = packed::small_differences(values, row);
    const std::size_t width = small ? 2 : 4, start = out.size();
    out.resize(start + 8 + width * values.size());
    std::byte* at = out.data() + start;
    const auto mark = static_cast<std::uint32_t>(width);
    std::memcpy(at, values.data(), 4);
    std::memcpy(at + 4, &mark, 4);
    at += 8;
    if (!small) {
        std::memcpy(at, values.data(), 4 * values.size());
        return;
    }
    const auto put = [&](std::size_t k, std::uint32_t difference) {
        const auto v = static_cast<std::uint16_t>(difference);
        std::memcpy(at + 2 * k, &v, 2);
    };
    for (std::size_t first = 0; first < values.size(); first += row) {
        put(first, first == 0 ? 0 : packed::difference(values.data(), first, row));
        for (std::size_t k = first + 1; k < first + row; ++k) put(k, packed::difference(values.data(), k, 1));
    }
}

// Reads a matrix and returns what follows it.
inline std::span<const std::byte> unpack(std::span<const std::byte> in, std::size_t row,
                                         std::span<std::int32_t> values) {
    std::uint32_t start, width;
    std::memcpy(&start, in.data(), 4);
    std::memcpy(&width, in.data() + 4, 4);
    const std::byte* at = in.data() + 8;
    if (width != 2) {
        std::memcpy(values.data(), at, 4 * values.size());
        return in.subspan(8 + 4 * values.size());
    }
    const auto step = [&](std::size_t k) {
        std::int16_t v;
        std::memcpy(&v, at + 2 * k, 2);
        return static_cast<std::uint32_t>(std::int32_t{v});
    };
    for (std::size_t first = 0; first < values.size(); first += row) {
        std::uint32_t value = start += step(first);
        values[first] = static_cast<std::int32_t>(value);
        for (std::size_t k = first + 1; k < first + row; ++k)
            values[k] = static_cast<std::int32_t>(value += step(k));
    }
    return in.subspan(8 + 2 * values.size());
}

}  // namespace carat
