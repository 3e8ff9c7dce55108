#include "gamma.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include "carat/codec/quantize.hpp"
#include "gamma_code.hpp"
#include "gamma_kernels.hpp"

namespace carat {
namespace {

constexpr int kGreatestSide = 128, kGreatestBlocks = kGreatestSide / 2 * (kGreatestSide / 2);

struct Place {
    std::uint8_t i, j;  // in leaves
};

// Row and column of Z-order numbers: bit 2r of the number is bit r of j, bit 2r + 1 of i.
constexpr auto kPlaces = [] {
    std::array<Place, kGreatestBlocks> t{};
    for (std::size_t m = 0; m < t.size(); ++m)
        for (int r = 0; r < 6; ++r) {
            t[m].j = static_cast<std::uint8_t>(t[m].j | (m >> (2 * r) & 1) << r);
            t[m].i = static_cast<std::uint8_t>(t[m].i | (m >> (2 * r + 1) & 1) << r);
        }
    return t;
}();

// Values of the leaf at a place that lie inside the matrix: height x width.
struct Shape {
    int i, j, height, width;
};
Shape shape_of(std::size_t leaf, int leaf_size, int rows) {
    const int i = kPlaces[leaf].i * leaf_size, j = kPlaces[leaf].j * leaf_size;
    return {i, j, std::min(leaf_size, rows - i), std::min(leaf_size, rows - j)};
}

// The bits 0, 2, 4, ... of x, moved together.
std::uint64_t even_bits(std::uint64_t x) {
    x &= 0x5555555555555555;
    x = (x | x >> 1) & 0x3333333333333333;
    x = (x | x >> 2) & 0x0F0F0F0F0F0F0F0F;
    x = (x | x >> 4) & 0x00FF00FF00FF00FF;
    x = (x | x >> 8) & 0x0000FFFF0000FFFF;
    return (x | x >> 16) & 0x00000000FFFFFFFF;
}

// Which blocks of each size hold a non-zero value, a bit a block: rows of the leaves, of blocks twice their
// size, ... of the root.
class ZeroPyramid {
  public:
    ZeroPyramid(std::span<const std::int32_t> values, int rows, int side, int leaf_size) {
        const auto n = static_cast<std::size_t>(rows), leaf = static_cast<std::size_t>(leaf_size);
        std::size_t blocks = static_cast<std::size_t>(side) / leaf;
        std::fill_n(levels_[0].begin(), blocks, 0);
        for (std::size_t i = 0; i < n; ++i) {
            std::array<std::uint64_t, kGreatestSide / 64> row{};
            kernel::nonzero_bits(values.data() + i * n, n, row.data());
            std::uint64_t pairs = even_bits(row[0] | row[0] >> 1) | even_bits(row[1] | row[1] >> 1) << 32;
            if (leaf == 4) pairs = even_bits(pairs | pairs >> 1);
            levels_[0][i / leaf] |= pairs;
        }
        for (; blocks > 1; blocks /= 2, ++depth_)
            for (std::size_t i = 0; i < blocks / 2; ++i) {
                const std::uint64_t both = levels_[depth_][2 * i] | levels_[depth_][2 * i + 1];
                levels_[depth_ + 1][i] = even_bits(both | both >> 1);
            }
    }
    std::size_t depth() const { return depth_; }
    bool any() const { return levels_[depth_][0] != 0; }
    // Four flags of the quadrants of block m (in Z-order) of level `finer` + 1, a bit each.
    unsigned quadrants(std::size_t finer, std::size_t m) const {
        const std::size_t i = 2 * std::size_t{kPlaces[m].i};
        const unsigned j = 2u * kPlaces[m].j;
        return static_cast<unsigned>((levels_[finer][i] >> j & 3) | (levels_[finer][i + 1] >> j & 3) << 2);
    }

  private:
    std::array<std::array<std::uint64_t, kGreatestSide / 2>, 7> levels_;
    std::size_t depth_ = 0;
};

// Room in both lists for all leaves of either size: they change places, and no later matrix then allocates.
void reserve_leaves(int side, std::vector<std::uint16_t>& a, std::vector<std::uint16_t>& b) {
    const auto most = static_cast<std::size_t>(side / 2 * (side / 2)) + 4;
    a.reserve(most);
    b.reserve(most);
}

// Four places at most; returns where the list ends then.
std::uint16_t* append_quadrants(unsigned mask, unsigned parent, std::uint16_t* to) {
    for (unsigned q = 0; q < 4; ++q) {
        *to = static_cast<std::uint16_t>(4 * parent + q);
        to += mask >> q & 1;
    }
    return to;
}

// Writes the flags; into `squares` the leaves that are not zero, in order.
template <class Sink>
void put_flags(const ZeroPyramid& pyramid, Sink& out, std::vector<std::uint16_t>& squares,
               std::vector<std::uint16_t>& finer) {
    out.put(pyramid.any() ? 1 : 0, 1);
    squares.assign(pyramid.any() ? 1 : 0, 0);
    if (!pyramid.any()) return;
    for (std::size_t level = pyramid.depth(); level-- > 0;) {
        finer.resize(4 * squares.size() + 4);
        std::uint16_t* end = finer.data();
        for (const std::uint16_t m : squares) {
            const unsigned mask = pyramid.quadrants(level, m);
            out.put(mask & (mask == 8 ? 7 : 15), mask == 8 ? 3 : 4);
            end = append_quadrants(mask, m, end);
        }
        finer.resize(static_cast<std::size_t>(end - finer.data()));
        std::swap(squares, finer);
    }
}

// Short codes on their way to a writer, many at a time.
class GatheredBits {
  public:
    explicit GatheredBits(BitWriter& out) : out_(out) {}
    // 0 <= count <= 33.
    void put(std::uint64_t value, int count) {
        if (filled_ + count > 56) flush();
        bits_ |= value << filled_;
        filled_ += count;
    }
    void flush() {
        out_.put(bits_, filled_);
        bits_ = 0;
        filled_ = 0;
    }

  private:
    BitWriter& out_;
    std::uint64_t bits_ = 0;
    int filled_ = 0;
};

struct BitCounter {
    std::uint64_t bits = 0;
    void put(std::uint64_t, int count) { bits += static_cast<std::uint64_t>(count); }
};

// The values of the leaves one after another.
void gather_leaves(std::span<const std::int32_t> values, int rows, int leaf_size,
                   const std::vector<std::uint16_t>& leaves, std::vector<std::int32_t>& out) {
    out.clear();
    for (const std::uint16_t leaf : leaves) {
        const Shape s = shape_of(leaf, leaf_size, rows);
        for (int i = 0; i < s.height; ++i) {
            const auto from = values.begin() + (s.i + i) * rows + s.j;
            out.insert(out.end(), from, from + s.width);
        }
    }
}

void scatter_leaves(const std::int32_t* from, int rows, int leaf_size,
                    const std::vector<std::uint16_t>& leaves, std::int32_t* values) {
    for (const std::uint16_t leaf : leaves) {
        const Shape s = shape_of(leaf, leaf_size, rows);
        std::int32_t* to = values + s.i * rows + s.j;
        if (s.height == 2 && s.width == 2) {
            std::memcpy(to, from, 8);
            std::memcpy(to + rows, from + 2, 8);
        } else if (s.height == 4 && s.width == 4) {
            for (int i = 0; i < 4; ++i) std::memcpy(to + i * rows, from + 4 * i, 16);
        } else {
            for (int i = 0; i < s.height; ++i)
                std::memcpy(to + i * rows, from + i * s.width,
                            sizeof(std::int32_t) * static_cast<std::size_t>(s.width));
        }
        from += s.height * s.width;
    }
}

// Of leaves inside the matrix, leaf_size wide: to[..] += step * from[..], modulo 2^32.
template <int kLeaf>
void add_leaf(const std::int32_t* from, std::int32_t step, std::ptrdiff_t stride, std::int32_t* to) {
    for (int i = 0; i < kLeaf; ++i)
        for (int j = 0; j < kLeaf; ++j)
            to[i * stride + j] = wrapping_add(to[i * stride + j], wrapping_mul(step, from[i * kLeaf + j]));
}

void add_leaves(const std::int32_t* from, std::int32_t step, int rows, int leaf_size,
                const std::vector<std::uint16_t>& leaves, std::int32_t* values) {
    for (const std::uint16_t leaf : leaves) {
        const Shape s = shape_of(leaf, leaf_size, rows);
        std::int32_t* to = values + s.i * rows + s.j;
        if (s.height == 2 && s.width == 2)
            add_leaf<2>(from, step, rows, to);
        else if (s.height == 4 && s.width == 4)
            add_leaf<4>(from, step, rows, to);
        else
            for (int i = 0; i < s.height; ++i)
                for (int j = 0; j < s.width; ++j)
                    to[i * rows + j] =
                        wrapping_add(to[i * rows + j], wrapping_mul(step, from[i * s.width + j]));
        from += s.height * s.width;
    }
}

void demand(kernel::RunEnd end) {
    if (end == kernel::RunEnd::truncated) throw Error(ErrorCode::truncated, "gamma code ends early");
    if (end == kernel::RunEnd::corrupt) throw Error(ErrorCode::corrupt, "gamma code above 2^32");
}

}  // namespace

void GammaWriter::add(std::span<const std::int32_t> values, int rows, int side, int leaf_size) {
    const ZeroPyramid pyramid(values, rows, side, leaf_size);
    reserve_leaves(side, leaves_, finer_);
    put_flags(pyramid, bits_, leaves_, finer_);
    sequence_.reserve(values.size());
    gather_leaves(values, rows, leaf_size, leaves_, sequence_);
    GatheredBits lengths(bits_);
    for (const std::int32_t v : sequence_) {
        const int n = static_cast<int>(std::bit_width(gamma_of(v))) - 1;
        lengths.put(std::uint64_t{1} << n, n + 1);
    }
    lengths.flush();
    GatheredBits suffixes(bits_);
    for (const std::int32_t v : sequence_) {
        const std::uint64_t code = gamma_of(v);
        const int n = static_cast<int>(std::bit_width(code)) - 1;
        suffixes.put(code ^ std::uint64_t{1} << n, n);
    }
    suffixes.flush();
}

std::uint64_t GammaWriter::cost(std::span<const std::int32_t> values, int rows, int side, int leaf_size) {
    BitCounter counter;
    const ZeroPyramid pyramid(values, rows, side, leaf_size);
    reserve_leaves(side, leaves_, finer_);
    put_flags(pyramid, counter, leaves_, finer_);
    // Zeros outside the leaves are counted too, then taken back: a bit each.
    const std::uint64_t sum = kernel::code_bits(values.data(), values.size());
    std::uint64_t inside = 0;
    for (const std::uint16_t leaf : leaves_) {
        const Shape s = shape_of(leaf, leaf_size, rows);
        inside += static_cast<std::uint64_t>(s.height * s.width);
    }
    return counter.bits + sum - (values.size() - inside);
}

void GammaReader::open(std::span<const std::byte> blob) {
    bytes_.resize(blob.size() + kernel::kBitRunPadding);
    if (!blob.empty()) std::memcpy(bytes_.data(), blob.data(), blob.size());
    std::fill(bytes_.begin() + static_cast<std::ptrdiff_t>(blob.size()), bytes_.end(), std::byte{0});
    bits_ = 8 * blob.size();
    at_ = 0;
}

std::uint64_t GammaReader::peek() const {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes_.data() + at_ / 8, 8);
    return word >> (at_ % 8);
}

void GammaReader::demand_inside() const {
    if (at_ > bits_) throw Error(ErrorCode::truncated, "gamma code ends inside its quadtree");
}

// Fills leaves_ with those that are not zero; returns how many.
std::size_t GammaReader::read_leaves(int side, int leaf_size) {
    const bool any = (peek() & 1) != 0;
    ++at_;
    reserve_leaves(side, leaves_, parents_);
    leaves_.assign(any ? 1 : 0, 0);
    for (int size = side; any && size > leaf_size; size /= 2) {
        std::swap(leaves_, parents_);
        leaves_.resize(4 * parents_.size() + 4);
        std::uint16_t* end = leaves_.data();
        std::size_t at = at_;
        for (std::size_t k = 0; k < parents_.size(); ++k) {
            if (at > bits_) break;  // found below
            std::uint32_t word = 0;
            std::memcpy(&word, bytes_.data() + at / 8, 4);
            word >>= at % 8;
            const unsigned implied = (word & 7) == 0 ? 1 : 0, mask = implied != 0 ? 8 : word & 15;
            at += 4 - implied;
            end = append_quadrants(mask, parents_[k], end);
        }
        at_ = at;
        demand_inside();
        leaves_.resize(static_cast<std::size_t>(end - leaves_.data()));
    }
    demand_inside();
    return leaves_.size();
}

void GammaReader::read_sequence(int rows, int side, int leaf_size) {
    if (read_leaves(side, leaf_size) == 0) return;
    std::size_t count = leaves_.size() * static_cast<std::size_t>(leaf_size * leaf_size);
    if (rows < side) {
        count = 0;
        for (const std::uint16_t leaf : leaves_) {
            const Shape s = shape_of(leaf, leaf_size, rows);
            count += static_cast<std::size_t>(s.height * s.width);
        }
    }
    ends_.resize(count + 80);
    sequence_.resize(count + 16);
    kernel::BitRun run{bytes_.data(), at_, bits_};
    std::uint8_t* ends = ends_.data() + 1;
    ends[-1] = static_cast<std::uint8_t>(at_ - 1);
    demand(kernel::ones(run, count, ends));
    demand(kernel::suffixes(run, count, ends, sequence_.data()));
    at_ = run.at;
}

void GammaReader::read(int rows, int side, int leaf_size, std::span<std::int32_t> values) {
    std::fill(values.begin(), values.end(), 0);
    read_sequence(rows, side, leaf_size);
    scatter_leaves(sequence_.data(), rows, leaf_size, leaves_, values.data());
}

void GammaReader::add(int rows, int side, int leaf_size, std::int32_t step, std::span<std::int32_t> values) {
    read_sequence(rows, side, leaf_size);
    add_leaves(sequence_.data(), step, rows, leaf_size, leaves_, values.data());
}

void GammaReader::finish() const {
    if (bits_ - at_ >= 8 || (peek() & 0xFF) != 0)
        throw Error(ErrorCode::corrupt, "gamma code has bits left over");
}

}  // namespace carat
