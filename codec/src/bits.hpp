// Bit strings, least significant bit of each byte first.
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <vector>

#include "carat/globe/error.hpp"

namespace carat {

class BitWriter {
  public:
    // Appends the low `count` bits of value, lowest first, the others being 0; 0 <= count <= 56.
    void put(std::uint64_t value, int count) {
        pending_ |= value << filled_;
        filled_ += count;
        if (bytes_.size() < size_ + 8) bytes_.resize(2 * size_ + 256);
        std::memcpy(bytes_.data() + size_, &pending_, 8);
        const int whole = filled_ & ~7;  // at most 56: 7 were left over, 56 came
        size_ += static_cast<std::size_t>(whole / 8);
        pending_ >>= whole;
        filled_ -= whole;
    }
    // Begins a new string in the same memory.
    void clear() {
        size_ = 0;
        pending_ = 0;
        filled_ = 0;
    }
    // Pads the last byte with zero bits. What is returned is valid until the writer is used again.
    std::span<const std::byte> finished() {
        if (filled_ > 0) put(0, 8 - filled_);
        return {bytes_.data(), size_};
    }
    // The same, for one's own; the writer's memory goes with it.
    std::vector<std::byte> finish() {
        finished();
        bytes_.resize(size_);
        size_ = 0;
        return std::move(bytes_);
    }

  private:
    std::vector<std::byte> bytes_;
    std::size_t size_ = 0;
    std::uint64_t pending_ = 0;
    int filled_ = 0;
};

// Reads past the end see zero bits; finish() throws if that happened.
class BitReader {
  public:
    explicit BitReader(std::span<const std::byte> bytes) : next_(bytes.data()), end_(next_ + bytes.size()) {}

    // At least 56 bits are buffered after refill (zeros past the end).
    void refill() {
        if (end_ - next_ >= 8) {
            std::uint64_t word = 0;
            std::memcpy(&word, next_, 8);
            buffer_ |= word << count_;
            const int taken = (63 - count_) >> 3;
            next_ += taken;
            count_ += taken * 8;
            return;
        }
        while (count_ <= 56) {
            if (next_ < end_)
                buffer_ |= static_cast<std::uint64_t>(*next_++) << count_;
            else
                past_end_ += 8;
            count_ += 8;
        }
    }
    std::uint64_t peek() const { return buffer_; }
    void skip(int bits) {
        buffer_ >>= bits;
        count_ -= bits;
    }
    std::uint64_t take(int bits) {
        const std::uint64_t value = buffer_ & ((std::uint64_t{1} << bits) - 1);
        skip(bits);
        return value;
    }
    // True once more bits were taken than there are.
    bool overrun() const { return past_end_ > count_; }
    // True if nothing was read past the end and all that was not read is zero.
    bool only_zeros_left() const {
        if (overrun() || buffer_ != 0) return false;
        for (const std::byte* p = next_; p != end_; ++p)
            if (*p != std::byte{0}) return false;
        return true;
    }
    // The whole string must have been read: only the padding of the last byte may remain, and it must be
    // zero.
    void finish() const {
        if (overrun()) throw Error(ErrorCode::truncated, "bit string ends early");
        const std::int64_t left = count_ - past_end_ + 8 * (end_ - next_);
        if (left >= 8 || buffer_ != 0) throw Error(ErrorCode::corrupt, "bit string has bits left over");
    }

  private:
    const std::byte* next_;
    const std::byte* end_;
    std::uint64_t buffer_ = 0;
    int count_ = 0;
    std::int64_t past_end_ = 0;
};

static_assert(std::endian::native == std::endian::little,
              "the file is little-endian and so must the machine be");

}  // namespace carat
