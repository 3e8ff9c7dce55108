// Heights in temporary files: a base and 16-bit offsets where these suffice, else 32 bits.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

namespace carat {

// Appends an array; the reader must know its length.
inline void pack(std::span<const std::int32_t> values, std::vector<std::byte>& out) {
    std::int32_t low = INT32_MAX, high = INT32_MIN;
    for (const std::int32_t v : values) {
        low = std::min(low, v);
        high = std::max(high, v);
    }
    const bool small = std::int64_t{high} - low <= UINT16_MAX;
    const std::size_t width = small ? 2 : 4, start = out.size();
    out.resize(start + 8 + width * values.size());
    std::byte* at = out.data() + start;
    const std::uint32_t mark = small ? 2 : 4;
    std::memcpy(at, &low, 4);
    std::memcpy(at + 4, &mark, 4);
    at += 8;
    for (std::size_t k = 0; k < values.size(); ++k) {
        if (small) {
            const auto v = static_cast<std::uint16_t>(values[k] - low);
            std::memcpy(at + 2 * k, &v, 2);
        } else {
            std::memcpy(at + 4 * k, &values[k], 4);
        }
    }
}

// Reads an array and returns what follows it.
inline std::span<const std::byte> unpack(std::span<const std::byte> in, std::span<std::int32_t> values) {
    std::int32_t low;
    std::uint32_t width;
    std::memcpy(&low, in.data(), 4);
    std::memcpy(&width, in.data() + 4, 4);
    const std::byte* at = in.data() + 8;
    if (width == 2) {
        for (std::size_t k = 0; k < values.size(); ++k) {
            std::uint16_t v;
            std::memcpy(&v, at + 2 * k, 2);
            values[k] = low + v;
        }
    } else {
        std::memcpy(values.data(), at, 4 * values.size());
    }
    return in.subspan(8 + width * values.size());
}

}  // namespace carat
