#include "gamma.hpp"

#include <algorithm>
#include <bit>

#include "gamma_code.hpp"

namespace carat {
namespace {

struct Block {
    int i, j, size;
};

constexpr Block quadrant(const Block& b, int k) {
    const int half = b.size / 2;
    return {b.i + (k >> 1) * half, b.j + (k & 1) * half, half};
}

// Which aligned blocks of each size hold a non-zero value: a pyramid of bits from the leaf size up.
class ZeroPyramid {
  public:
    ZeroPyramid(std::span<const std::int32_t> values, int rows, int side, int leaf_size) : leaf_(leaf_size) {
        int blocks = side / leaf_size;
        levels_.emplace_back(static_cast<std::size_t>(blocks * blocks));
        for (int i = 0; i < rows; ++i) {
            const std::int32_t* row = values.data() + static_cast<std::ptrdiff_t>(i) * rows;
            auto* out = levels_[0].data() + static_cast<std::ptrdiff_t>(i / leaf_size) * blocks;
            for (int j = 0; j < rows; ++j) out[j / leaf_size] |= row[j] != 0 ? 1 : 0;
        }
        while (blocks > 1) {
            const auto& fine = levels_.back();
            std::vector<std::uint8_t> coarse(static_cast<std::size_t>(blocks * blocks / 4));
            for (int i = 0; i < blocks; ++i)
                for (int j = 0; j < blocks; ++j)
                    coarse[static_cast<std::size_t>((i / 2) * (blocks / 2) + j / 2)] |=
                        fine[static_cast<std::size_t>(i * blocks + j)];
            blocks /= 2;
            levels_.push_back(std::move(coarse));
        }
        side_ = side;
    }
    bool nonzero(const Block& b) const {
        const auto level = static_cast<std::size_t>(std::countr_zero(static_cast<unsigned>(b.size / leaf_)));
        const int blocks = side_ / b.size;
        return levels_[level][static_cast<std::size_t>((b.i / b.size) * blocks + b.j / b.size)] != 0;
    }

  private:
    std::vector<std::vector<std::uint8_t>> levels_;
    int leaf_, side_;
};

struct BitCounter {
    std::uint64_t bits = 0;
    void put(std::uint64_t, int count) { bits += static_cast<std::uint64_t>(count); }
};

template <class Sink>
class Encoder {
  public:
    Encoder(std::span<const std::int32_t> values, int rows, int side, int leaf_size, Sink& out)
        : values_(values), rows_(rows), leaf_(leaf_size), pyramid_(values, rows, side, leaf_size), out_(out) {
        block({0, 0, side}, false);
    }

  private:
    void block(const Block& b, bool must_be_nonzero) {
        const bool nonzero = pyramid_.nonzero(b);
        if (!must_be_nonzero) out_.put(nonzero ? 1 : 0, 1);
        if (!nonzero) return;
        if (b.size == leaf_) return leaf(b);
        bool any = false;
        for (int k = 0; k < 4; ++k) {
            const Block q = quadrant(b, k);
            block(q, k == 3 && !any);
            any = any || pyramid_.nonzero(q);
        }
    }
    void leaf(const Block& b) {
        for (int i = b.i; i < std::min(b.i + b.size, rows_); ++i)
            for (int j = b.j; j < std::min(b.j + b.size, rows_); ++j)
                put_gamma(out_, values_[static_cast<std::size_t>(i * rows_ + j)]);
    }

    std::span<const std::int32_t> values_;
    int rows_, leaf_;
    ZeroPyramid pyramid_;
    Sink& out_;
};

class Decoder {
  public:
    Decoder(BitReader& in, int rows, int leaf_size, std::int32_t* values)
        : in_(in), rows_(rows), leaf_(leaf_size), values_(values) {}

    bool block(const Block& b, bool must_be_nonzero) {
        if (!must_be_nonzero) {
            in_.refill();
            if (in_.take(1) == 0) return false;
        }
        if (b.size == leaf_) {
            leaf(b);
            return true;
        }
        if (in_.overrun()) throw Error(ErrorCode::truncated, "gamma code ends inside its quadtree");
        bool any = false;
        for (int k = 0; k < 4; ++k) any |= block(quadrant(b, k), k == 3 && !any);
        return true;
    }

  private:
    void leaf(const Block& b) {
        const int i_end = std::min(b.i + b.size, rows_), j_end = std::min(b.j + b.size, rows_);
        for (int i = b.i; i < i_end; ++i)
            for (int j = b.j; j < j_end; ++j) values_[i * rows_ + j] = take_gamma(in_);
    }

    BitReader& in_;
    int rows_, leaf_;
    std::int32_t* values_;
};

}  // namespace

void gamma_encode(std::span<const std::int32_t> values, int rows, int side, int leaf_size, BitWriter& out) {
    Encoder<BitWriter>(values, rows, side, leaf_size, out);
}

std::uint64_t gamma_cost(std::span<const std::int32_t> values, int rows, int side, int leaf_size) {
    BitCounter counter;
    Encoder<BitCounter>(values, rows, side, leaf_size, counter);
    return counter.bits;
}

void gamma_decode(BitReader& in, int rows, int side, int leaf_size, std::span<std::int32_t> values) {
    std::fill(values.begin(), values.end(), 0);
    Decoder(in, rows, leaf_size, values.data()).block({0, 0, side}, false);
}

}  // namespace carat
