// Little-endian numbers in byte strings.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "carat/globe/error.hpp"

namespace carat {

template <class T>
void put(std::vector<std::byte>& out, T value) {
    static_assert(std::is_arithmetic_v<T>);
    const auto raw = std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
    out.insert(out.end(), raw.begin(), raw.end());
}

// LEB128: 7 bits a byte, lowest first.
inline void put_varint(std::vector<std::byte>& out, std::uint64_t value) {
    for (; value >= 0x80; value >>= 7) out.push_back(static_cast<std::byte>(value | 0x80));
    out.push_back(static_cast<std::byte>(value));
}

inline std::size_t varint_bytes(std::uint64_t value) {
    std::size_t n = 1;
    for (; value >= 0x80; value >>= 7) ++n;
    return n;
}

// Parses foreign bytes. Throws Error(truncated) past the end, naming `what`.
class ByteParser {
  public:
    ByteParser(std::span<const std::byte> bytes, std::string what) : bytes_(bytes), what_(std::move(what)) {}

    std::size_t left() const { return bytes_.size(); }
    const std::string& what() const { return what_; }

    template <class T>
    T get() {
        static_assert(std::is_arithmetic_v<T>);
        T value;
        std::memcpy(&value, take(sizeof(T)).data(), sizeof(T));
        return value;
    }
    std::span<const std::byte> take(std::size_t count) {
        if (count > bytes_.size()) throw Error(ErrorCode::truncated, what_ + " ends early");
        const auto head = bytes_.first(count);
        bytes_ = bytes_.subspan(count);
        return head;
    }
    std::string text(std::size_t count) {
        const auto head = take(count);
        return {reinterpret_cast<const char*>(head.data()), head.size()};
    }
    // At most 32 bits.
    std::uint32_t varint() {
        std::uint64_t value = 0;
        for (int shift = 0; shift < 35; shift += 7) {
            const auto byte = get<std::uint8_t>();
            value |= static_cast<std::uint64_t>(byte & 0x7F) << shift;
            if ((byte & 0x80) != 0) continue;
            if (value > UINT32_MAX || (byte == 0 && shift > 0)) break;
            return static_cast<std::uint32_t>(value);
        }
        fail("has a malformed length");
    }
    [[noreturn]] void fail(const std::string& cause) const {
        throw Error(ErrorCode::corrupt, what_ + " " + cause);
    }

  private:
    std::span<const std::byte> bytes_;
    std::string what_;
};

}  // namespace carat
