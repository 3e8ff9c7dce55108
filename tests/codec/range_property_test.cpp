// The range coder's parts against plain loops, and whole codes back and forth, on every vector target that
// the machine has.
#include <gtest/gtest.h>

#include <algorithm>

#include "carat/globe/error.hpp"
#include "gather_kernel.hpp"
#include "globe/random.hpp"
#include "range.hpp"
#include "range_kernels.hpp"
#include "support/every_target.hpp"

namespace carat::test {
namespace {

std::vector<std::uint8_t> random_tokens(Random& random, std::size_t count, int most) {
    std::vector<std::uint8_t> out(count);
    for (auto& t : out) t = static_cast<std::uint8_t>(random.chance(0.4) ? random.integer(0, most) : 0);
    return out;
}

TEST(RangeKernels, PassesAreTheColoursOfAChessBoard) {
    Random random;
    SCOPED_TRACE(random.trace());
    on_every_target([&] {
        for (const int rows : {2, 3, 7, 15, 16, 31, 63, 64, 65, 127}) {
            const std::size_t side = static_cast<std::size_t>(rows), pitch = (side + 1) / 2,
                              stride = side + 3;
            std::vector<std::uint32_t> cells(side * stride);
            for (auto& x : cells) x = static_cast<std::uint32_t>(random.bits());
            const std::vector<std::uint8_t> bytes = random_tokens(random, side * side, 63);
            std::vector<std::uint32_t> p0(side * pitch), p1(p0);
            std::vector<std::uint8_t> b0(side * pitch), b1(b0), back(side * side);
            kernel::split_passes(cells.data(), stride, rows, 77u, p0.data(), p1.data());
            kernel::split_passes(bytes.data(), side, rows, b0.data(), b1.data());
            kernel::merge_passes(b0.data(), b1.data(), rows, back.data());
            ASSERT_EQ(back, bytes);
            for (std::size_t i = 0; i < side; ++i)
                for (std::size_t j = 0; j < side; ++j) {
                    const std::size_t at = i * pitch + j / 2;
                    ASSERT_EQ(((i + j) % 2 == 0 ? p0 : p1)[at], cells[i * stride + j]) << rows;
                    ASSERT_EQ(((i + j) % 2 == 0 ? b0 : b1)[at], bytes[i * side + j]) << rows;
                }
            if (rows % 2 != 0) {
                ASSERT_EQ(p1[pitch - 1], 77u);
                ASSERT_EQ(b1[pitch - 1], 0u);
            }
        }
    });
}

TEST(RangeKernels, NeighboursAreTheFourAroundAndBigOnesCountSixtyThree) {
    Random random;
    SCOPED_TRACE(random.trace());
    on_every_target([&] {
        for (const int rows : {2, 3, 7, 31, 63, 64, 65, 127}) {
            const std::size_t side = static_cast<std::size_t>(rows), pitch = (side + 1) / 2;
            const std::vector<std::uint8_t> token = random_tokens(random, side * side, 63);
            std::vector<std::uint8_t> p0(side * pitch), p1(p0), near(p0), scratch;
            kernel::split_passes(token.data(), side, rows, p0.data(), p1.data());
            kernel::neighbour_magnitudes(p0.data(), rows, scratch, near.data());
            for (int i = 0; i < rows; ++i)
                for (int j = 1 - i % 2; j < rows; j += 2) {
                    int sum = 0;
                    const auto add = [&](int r, int c) {
                        if (r < 0 || c < 0 || r >= rows || c >= rows) return;
                        sum += seen_magnitude(token[static_cast<std::size_t>(r * rows + c)]);
                    };
                    add(i - 1, j);
                    add(i + 1, j);
                    add(i, j - 1);
                    add(i, j + 1);
                    ASSERT_EQ(near[static_cast<std::size_t>(i) * pitch + static_cast<std::size_t>(j / 2)],
                              sum)
                        << rows << ' ' << i << ' ' << j;
                }
        }
    });
}

TEST(RangeKernels, TokensAndSignsMakeTheIndicesAgain) {
    Random random;
    SCOPED_TRACE(random.trace());
    on_every_target([&] {
        for (const std::size_t count :
             {std::size_t{1}, std::size_t{31}, std::size_t{64}, std::size_t{3969}, std::size_t{4096}})
            for (const int reach : {1, 15, 16, 40000}) {
                std::vector<std::int32_t> index(count), back(count);
                for (auto& e : index)
                    e = random.chance(0.5) ? static_cast<std::int32_t>(random.integer(-reach, reach)) : 0;
                std::vector<std::uint8_t> token(count), raw(count / 8 + 9);
                std::vector<std::uint16_t> big(count);
                kernel::make_tokens(index.data(), count, token.data());
                std::size_t nonzero = 0, large = 0;
                for (std::size_t k = 0; k < count; ++k) {
                    ASSERT_EQ(token[k], token_of(magnitude_of(index[k])));
                    if (token[k] >= kDirectTokens) ++large;
                    if (index[k] == 0) continue;
                    raw[nonzero / 8] |= static_cast<std::uint8_t>((index[k] < 0 ? 1 : 0) << (nonzero % 8));
                    ++nonzero;
                }
                const kernel::TokenCensus census = kernel::take_census(token.data(), count, big.data());
                ASSERT_EQ(census.nonzero, nonzero);
                ASSERT_EQ(census.big, large);
                for (std::size_t k = 0; k < large; ++k) ASSERT_GE(token[big[k]], kDirectTokens);
                kernel::apply_signs(token.data(), count, raw.data(), back.data());
                for (std::size_t k = 0; k < count; ++k)
                    ASSERT_EQ(back[k], with_sign(token[k], index[k] < 0 ? 1 : 0)) << k;
            }
    });
}

struct Matrices {
    int m, rows;
    std::vector<std::int32_t> known, index;
};

// Rough and smooth, sparse and dense; at `extreme` with any int32 at all.
Matrices random_matrices(Random& random, int m, int rows, bool extreme) {
    Matrices out{m, rows, {}, {}};
    const auto reach = static_cast<std::int64_t>(1) << random.integer(0, 20);
    const double density = random.real(0, 1);
    for (int k = 0; k < m * m; ++k)
        out.known.push_back(extreme ? static_cast<std::int32_t>(random.bits())
                                    : static_cast<std::int32_t>(random.integer(-reach, reach)));
    for (int k = 0; k < rows * rows; ++k)
        out.index.push_back(!random.chance(density) ? 0
                            : extreme ? static_cast<std::int32_t>(random.bits()) >> random.integer(0, 31)
                                      : static_cast<std::int32_t>(random.integer(-3, 3)));
    return out;
}

TEST(Range, CodesComeBackOnEveryTargetWithTheSameBytes) {
    Random random;
    SCOPED_TRACE(random.trace());
    const RangeTables::Model& model = RangeTables::built_in()->model();
    for (int round = 0; round < 60; ++round) {
        const int m = std::array{5, 9, 17, 33, 65, 64}[static_cast<std::size_t>(random.integer(0, 5))];
        const int rows = m - 1 - (random.chance(0.3) ? 1 : 0);
        const Matrices x = random_matrices(random, m, rows, random.chance(0.3));
        const RangeInput in{x.known.data(), m, rows, static_cast<std::int32_t>(random.integer(0, 1 << 12)),
                            random.chance(0.5) ? Activity::corners : Activity::window};
        std::vector<std::byte> first;
        on_every_target([&] {
            RangeScratch scratch;
            std::vector<std::byte> bytes;
            range_encode(model, in, x.index, scratch, nullptr, bytes);
            if (first.empty()) first = bytes;
            ASSERT_EQ(bytes, first);
            std::vector<std::int32_t> back(x.index.size(), 99);
            range_decode(model, in, bytes, scratch, back);
            ASSERT_EQ(back, x.index);
        });
    }
}

TEST(Range, CutCodesAreRefused) {
    Random random;
    SCOPED_TRACE(random.trace());
    const RangeTables::Model& model = RangeTables::built_in()->model();
    const Matrices x = random_matrices(random, 65, 64, false);
    const RangeInput in{x.known.data(), 65, 64, 3};
    RangeScratch scratch;
    std::vector<std::byte> bytes;
    range_encode(model, in, x.index, scratch, nullptr, bytes);
    std::vector<std::int32_t> back(x.index.size());
    for (std::size_t length = 0; length < bytes.size(); ++length)
        EXPECT_THROW(range_decode(model, in, std::span(bytes).first(length), scratch, back), Error) << length;
}

bool lies_in(Triangle part, int n, int i, int j) {
    switch (part) {
        case Triangle::left_lower:
            return i >= j;
        case Triangle::right_upper:
            return i <= j;
        case Triangle::left_upper:
            return i + j <= n - 1;
        case Triangle::right_lower:
            break;
    }
    return i + j >= n - 1;
}

// Against the map's definition; what lies outside the half stays as it was.
void expect_gathered(Random& random, int n, const ChildMap& m, Triangle part) {
    std::vector<std::int32_t> v(static_cast<std::size_t>(n * n)),
        c(static_cast<std::size_t>((n - 1) * (n - 1))), out(v.size(), 5);
    for (auto& x : v) x = static_cast<std::int32_t>(random.bits());
    for (auto& x : c) x = static_cast<std::int32_t>(random.bits());
    kernel::gather_half(v.data(), c.data(), n, m, part, out.data());
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            const std::int32_t got = out[static_cast<std::size_t>(i * n + j)];
            if (!lies_in(part, n, i, j)) {
                ASSERT_EQ(got, 5) << "outside the half";
                continue;
            }
            const int p = m.p0 + i * m.pi + j * m.pj, q = m.q0 + i * m.qi + j * m.qj;
            ASSERT_EQ(got, p % 2 == 0 ? v[static_cast<std::size_t>(p / 2 * n + q / 2)]
                                      : c[static_cast<std::size_t>(p / 2 * (n - 1) + q / 2)])
                << n << ' ' << i << ' ' << j;
        }
}

// Rows counted from the other end.
ChildMap upside_down(ChildMap m, int cells) {
    m.p0 += cells * m.pi;
    m.q0 += cells * m.qi;
    m.pi = -m.pi;
    m.qi = -m.qi;
    return m;
}

TEST(GatherHalf, TakesVerticesAndCentresWhereTheMapSays) {
    Random random;
    SCOPED_TRACE(random.trace());
    on_every_target([&] {
        for (const int n : {5, 9, 17, 33, 65, 129})
            for (const DiamondId parent : {root_diamond(0), child(root_diamond(3), 1)})
                for (const DiamondId child : children(parent))
                    for (const int side : {0, 1}) {
                        const Half half{child, side};
                        const auto inside = parent_half(half);
                        if (!inside || inside->diamond != parent) continue;
                        const ChildMap m = child_map(parent, half, n - 1);
                        expect_gathered(random, n, m,
                                        side == 0 ? Triangle::left_lower : Triangle::right_upper);
                        expect_gathered(random, n, upside_down(m, n - 1),
                                        side == 0 ? Triangle::left_upper : Triangle::right_lower);
                    }
    });
}

}  // namespace
}  // namespace carat::test
