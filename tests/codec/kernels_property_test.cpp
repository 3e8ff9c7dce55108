// The kernels over whole matrices of the default patch size against plain loops, on every vector target that
// the machine has; and whole diamonds of that size.
#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cstdlib>

#include "carat/codec/diamond_codec.hpp"
#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "gamma.hpp"
#include "gamma_code.hpp"
#include "gamma_kernels.hpp"
#include "globe/random.hpp"
#include "kernels.hpp"
#include "support/every_target.hpp"
#include "update_kernels.hpp"

namespace carat::test {
namespace {

using Matrix = std::vector<std::int32_t>;

constexpr int kN = 65;
constexpr std::int64_t kReaches[] = {3, 1000, (1 << 21) - 1, 1 << 21, (1ll << 31) - 1};  // narrow up to 2^21
constexpr std::int32_t kRadii[] = {0, 1, 5, 127, 128, 1000, (1 << 29) - 1, 1 << 29};

std::size_t square(int side) { return static_cast<std::size_t>(side) * static_cast<std::size_t>(side); }

Matrix random_matrix(Random& random, int side, std::int64_t reach) {
    Matrix out(square(side));
    for (auto& x : out) x = static_cast<std::int32_t>(random.integer(-reach - 1, reach));
    return out;
}

TEST(Kernels, PredictionIsThePlainLoops) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const int m : {kN, kN - 1})
        for (const std::int64_t reach : kReaches)
            for (const Order order : {Order::two, Order::four, Order::six}) {
                const Matrix in = random_matrix(random, m, reach);
                Matrix plain(square(m - 1));
                predict_centres_plain(in.data(), m, order, plain.data());
                on_every_target([&] {
                    Matrix fast(plain.size());
                    kernel::predict(in.data(), m, order, fast.data());
                    ASSERT_EQ(fast, plain) << m << ' ' << reach << ' ' << static_cast<int>(order);
                });
            }
}

TEST(Kernels, IndicesAndReconstructionAreThePlainLoops) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const std::int32_t radius : kRadii)
        for (const std::int64_t reach : kReaches) {
            const Matrix target = random_matrix(random, kN - 1, reach),
                         prediction = random_matrix(random, kN - 1, reach);
            Matrix index(target.size()), value(target.size());
            for (std::size_t k = 0; k < target.size(); ++k) {
                index[k] = quantize(wrapping_sub(target[k], prediction[k]), radius);
                value[k] = wrapping_add(prediction[k], dequantize(index[k], radius));
            }
            const bool any = std::any_of(index.begin(), index.end(), [](std::int32_t e) { return e != 0; });
            on_every_target([&] {
                Matrix fast_index(target.size()), fast_value(target.size());
                ASSERT_EQ(kernel::quantize(target.data(), prediction.data(), target.size(), radius,
                                           fast_index.data()),
                          any);
                ASSERT_EQ(fast_index, index) << radius << ' ' << reach;
                kernel::reconstruct(prediction.data(), index.data(), index.size(), 2 * radius + 1,
                                    fast_value.data());
                ASSERT_EQ(fast_value, value) << radius << ' ' << reach;
            });
        }
}

// ---- the update of modes 1 and 2 ----

struct Vertices {
    Matrix v, p, predicted;
};

// f(number of the vertex, number among the inner ones).
template <class F>
void for_inner(F f) {
    std::size_t inner = 0;
    for (int i = 1; i < kN - 1; ++i)
        for (int j = 1; j < kN - 1; ++j) f(static_cast<std::size_t>(i * kN + j), inner++);
}

TEST(Kernels, UpdateIsThePlainLoops) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const std::int32_t radius : kRadii)
        for (const std::int64_t reach : kReaches)
            for (const bool paper : {false, true}) {
                const Vertices x{random_matrix(random, kN, reach), random_matrix(random, kN, reach),
                                 random_matrix(random, kN - 2, reach)};
                Matrix index(square(kN - 2)), v(square(kN), 77);
                for_inner([&](std::size_t at, std::size_t inner) {
                    const std::int32_t base =
                        paper ? wrapping_sub(wrapping_mul(2, x.p[at]), x.predicted[inner]) : x.p[at];
                    index[inner] = quantize(wrapping_sub(x.v[at], base), radius);
                    v[at] = wrapping_add(base, dequantize(index[inner], radius));
                });
                const kernel::VertexBase base{x.p.data(), paper ? x.predicted.data() : nullptr};
                on_every_target([&] {
                    Matrix fast_index(index.size()), fast_v(v.size(), 77);
                    kernel::quantize_vertices(x.v.data(), base, kN, radius, fast_index.data());
                    ASSERT_EQ(fast_index, index) << radius << ' ' << reach << ' ' << paper;
                    kernel::update_vertices(base, index.data(), kN, 2 * radius + 1, fast_v.data());
                    ASSERT_EQ(fast_v, v) << radius << ' ' << reach << ' ' << paper;
                });
            }
}

TEST(Kernels, FilterIsThePlainLoop) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const std::int64_t reach : kReaches) {
        const Vertices x{random_matrix(random, kN, reach), {}, random_matrix(random, kN - 2, reach)};
        Matrix p(square(kN), 77);
        for_inner([&](std::size_t at, std::size_t inner) {
            const std::int64_t mean = (std::int64_t{x.v[at]} + x.predicted[inner] + 1) >> 1;
            p[at] =
                static_cast<std::int32_t>(std::clamp<std::int64_t>(mean, -kGreatestHeight, kGreatestHeight));
        });
        on_every_target([&] {
            Matrix fast(p.size(), 77);
            kernel::filter_vertices(x.v.data(), x.predicted.data(), kN, fast.data());
            ASSERT_EQ(fast, p) << reach;
            std::copy(x.predicted.begin(), x.predicted.end(), fast.begin());
            kernel::filter_vertices(x.v.data(), fast.data(), kN, fast.data());
            for_inner([&](std::size_t at, std::size_t) { ASSERT_EQ(fast[at], p[at]) << reach << ' ' << at; });
        });
    }
}

// ---- contexts: docs/format.md, 8.6 ----

struct PlainActivity {
    const Matrix& k;
    int m;
    ActivityScale scale;

    std::int64_t at(int i, int j) const { return k[static_cast<std::size_t>(i * m + j)]; }
    std::int64_t scaled(std::int64_t x) const {
        const std::int64_t wrapped = static_cast<std::int32_t>(static_cast<std::uint32_t>(x));
        return std::min<std::int64_t>(1 << 23, std::abs(wrapped) >> scale.shift);
    }
    std::int64_t roughness(int i, int j) const {
        i = std::clamp(i, 0, m - 1);
        j = std::clamp(j, 0, m - 1);
        const int r = std::clamp(i, 1, m - 2), c = std::clamp(j, 1, m - 2);
        return scaled(at(i, c - 1) - 2 * at(i, c) + at(i, c + 1)) +
               scaled(at(r - 1, j) - 2 * at(r, j) + at(r + 1, j));
    }
    std::int64_t window(int i, int j) const {
        constexpr std::int64_t kWeight[] = {1, 2, 2, 1};
        std::int64_t sum = 8 * scaled(at(i, j) + at(i + 1, j + 1) - at(i, j + 1) - at(i + 1, j));
        for (int a = -1; a <= 2; ++a)
            for (int b = -1; b <= 2; ++b) sum += kWeight[a + 1] * kWeight[b + 1] * roughness(i + a, j + b);
        return sum;
    }
    std::int64_t corners(int i, int j) const {
        const std::int64_t total = at(i, j) + at(i, j + 1) + at(i + 1, j) + at(i + 1, j + 1);
        std::int64_t sum = 0;
        for (int a = 0; a < 2; ++a)
            for (int b = 0; b < 2; ++b)
                sum += 5 * roughness(i + a, j + b) + 7 * scaled(4 * at(i + a, j + b) - total);
        return sum;
    }
};

TEST(Kernels, ActivitiesAreThoseOfTheFormat) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const int m : {kN, kN - 1})
        for (const std::int32_t radius : kRadii)
            for (const std::int64_t reach : kReaches)
                for (const Activity kind : {Activity::window, Activity::corners}) {
                    const Matrix in = random_matrix(random, m, reach);
                    const PlainActivity plain{in, m, ActivityScale(radius)};
                    std::vector<std::uint32_t> expected;
                    for (int i = 0; i < m - 1; ++i)
                        for (int j = 0; j < m - 1; ++j)
                            expected.push_back(static_cast<std::uint32_t>(
                                24 * plain.scale.step +
                                (kind == Activity::window ? plain.window(i, j) : plain.corners(i, j))));
                    on_every_target([&] {
                        ActivityScratch scratch;
                        std::vector<std::uint32_t> fast(expected.size());
                        kernel::cell_activity(in.data(), m, plain.scale, kind, scratch, fast.data());
                        ASSERT_EQ(fast, expected) << m << ' ' << radius << ' ' << reach;
                    });
                }
}

TEST(Kernels, ContextsAreThoseOfTheFormat) {
    Random random;
    SCOPED_TRACE(random.trace());
    const auto log8 = [](std::int64_t x) {
        const int e = static_cast<int>(std::bit_width(static_cast<std::uint64_t>(x))) - 1;
        return 8 * e + (x >> (e - 3)) - 8;
    };
    const std::size_t count = square(kN - 1) / 2;
    for (int round = 0; round < 40; ++round) {
        const auto weight = static_cast<std::uint32_t>(48 * random.integer(1, 4095));
        const auto bias = static_cast<int>(random.integer(-300, 20));
        const auto base = static_cast<std::uint8_t>(64 * (round % 2));
        std::vector<std::uint32_t> activity(count);
        std::vector<std::uint8_t> near(count), expected;
        for (auto& a : activity)
            a = static_cast<std::uint32_t>(random.integer(24, (1ll << 30) >> random.integer(0, 25)));
        for (auto& x : near) x = static_cast<std::uint8_t>(random.integer(0, 252));
        for (std::size_t k = 0; k < count; ++k) {
            const std::int64_t u = activity[k] + (base != 0 ? std::int64_t{weight} * near[k] : 0);
            const std::int64_t halves = log8(u) + bias;
            expected.push_back(
                static_cast<std::uint8_t>(base + std::clamp<std::int64_t>(halves >> 1, 0, 63)));
        }
        on_every_target([&] {
            std::vector<std::uint8_t> fast(count);
            kernel::contexts(activity.data(), base != 0 ? near.data() : nullptr, weight, count, bias, base,
                             fast.data());
            ASSERT_EQ(fast, expected);
        });
    }
}

// ---- gamma ----

Matrix sparse_matrix(Random& random, int rows, double density) {
    Matrix out(square(rows));
    const auto shift = random.integer(0, 31);
    for (auto& x : out)
        if (random.chance(density))
            x = static_cast<std::int32_t>(random.bits()) >> std::max(shift, random.integer(0, 31));
    return out;
}

TEST(Kernels, GammaRunsAreThePlainLoops) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const int rows : {kN - 1, kN - 2})
        for (const double density : {0.0, 0.01, 0.3, 1.0})
            for (int round = 0; round < 6; ++round) {
                const Matrix values = sparse_matrix(random, rows, density);
                std::uint64_t bits = 0;
                for (const std::int32_t v : values)
                    bits += 2 * static_cast<std::uint64_t>(std::bit_width(gamma_of(v))) - 1;
                std::vector<std::uint64_t> nonzero((values.size() + 63) / 64);
                for (std::size_t k = 0; k < values.size(); ++k)
                    nonzero[k / 64] |= std::uint64_t{values[k] != 0 ? 1u : 0u} << (k % 64);
                const int leaf = round % 2 == 0 ? 2 : 4;
                GammaWriter writer;
                writer.add(values, rows, kN - 1, leaf);
                const std::span<const std::byte> written = writer.finish();
                const std::vector<std::byte> code(written.begin(), written.end());
                on_every_target([&] {
                    ASSERT_EQ(kernel::code_bits(values.data(), values.size()), bits);
                    std::vector<std::uint64_t> fast(nonzero.size());
                    kernel::nonzero_bits(values.data(), values.size(), fast.data());
                    ASSERT_EQ(fast, nonzero);
                    writer.open();
                    writer.add(values, rows, kN - 1, leaf);
                    ASSERT_TRUE(std::ranges::equal(writer.finish(), code));
                    ASSERT_EQ((writer.cost(values, rows, kN - 1, leaf) + 7) / 8, code.size());
                    GammaReader reader;
                    Matrix back(values.size(), 7);
                    reader.open(code);
                    reader.read(rows, kN - 1, leaf, back);
                    reader.finish();
                    ASSERT_EQ(back, values);
                });
            }
}

// Both coders, all modes: a code of the best target, read on every other, and made there again.
TEST(Kernels, WholeDiamondsAreCodedAlike) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const std::int64_t reach : {100ll, 5000ll, 1ll << 28})
        for (const Mode mode : {Mode::interpolating, Mode::filtered, Mode::paper})
            for (const Coding& coding : {Coding{}, Coding::gamma(), Coding::paper()}) {
                const RefinedHeights reference{kN, random_matrix(random, kN, reach),
                                               random_matrix(random, kN - 1, reach)};
                Matrix p(reference.v);
                if (mode != Mode::interpolating) filter_vertices(reference, p);
                CodecScratch scratch;
                RefinedHeights out;
                const EncodedResiduals e = encode_residuals(coding, mode, p, reference, 50, out, scratch);
                on_every_target([&] {
                    RefinedHeights back, again;
                    decode_residuals(coding, e.info, e.blob, p, kN, 50, back, scratch);
                    ASSERT_EQ(back.v, out.v);
                    ASSERT_EQ(back.c, out.c);
                    const EncodedResiduals same =
                        encode_residuals(coding, mode, p, reference, 50, again, scratch);
                    ASSERT_EQ(same.blob, e.blob);
                    ASSERT_EQ(same.info, e.info);
                    Matrix filtered(p);
                    if (mode != Mode::interpolating) filter_vertices(reference, filtered);
                    ASSERT_EQ(filtered, p);
                });
            }
}

}  // namespace
}  // namespace carat::test
