// The codec's small pieces against independent formulas: prediction, quantiser, bit strings, Elias-gamma
// codes.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <limits>

#include "bits.hpp"
#include "bytes.hpp"
#include "carat/codec/diamond_codec.hpp"
#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/error.hpp"
#include "gamma.hpp"
#include "gamma_code.hpp"
#include "globe/random.hpp"

namespace carat::test {
namespace {

constexpr std::int32_t kLeast = std::numeric_limits<std::int32_t>::min(),
                       kMost = std::numeric_limits<std::int32_t>::max();

ErrorCode code_of(const std::function<void()>& action) {
    try {
        action();
    } catch (const Error& e) {
        return e.code();
    }
    ADD_FAILURE() << "no error";
    return ErrorCode::io;
}

// ---- prediction ----

// Weights in 1/32 of every sample, straight from the definition; exact rational arithmetic in 128 bits.
std::int32_t predicted(const std::vector<std::int32_t>& k, int m, int i, int j) {
    __extension__ using Wide = __int128;
    const auto at = [&](int r, int c) {
        return static_cast<Wide>(k.at(static_cast<std::size_t>(r * m + c)));
    };
    const bool row = i == 0 || i == m - 2, column = j == 0 || j == m - 2;
    Wide sum = 16;
    for (int r = -1; r <= 2; ++r)
        for (int c = -1; c <= 2; ++c) {
            const bool near_r = r == 0 || r == 1, near_c = c == 0 || c == 1;
            int weight = 0;
            if (near_r && near_c) weight = row && column ? 8 : row || column ? 9 : 10;
            if (near_r != near_c && !(row && column))
                weight = (row && !near_r) || (column && !near_c) ? 0 : -1;
            if (weight != 0) sum += weight * at(i + r, j + c);
        }
    // Floor of the division, then the low 32 bits.
    const Wide quotient = sum >= 0 ? sum / 32 : -((31 - sum) / 32);
    return static_cast<std::int32_t>(static_cast<std::uint32_t>(quotient & 0xFFFFFFFF));
}

TEST(Predict, AgreesWithTheDefinitionForAllOfInt32) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const int m : {4, 5, 8, 9, 16, 17, 64, 65})
        for (const std::int64_t reach : {3ll, 100000ll, 1ll << 30, (1ll << 31) - 1}) {
            std::vector<std::int32_t> k(static_cast<std::size_t>(m * m));
            for (auto& x : k)
                x = static_cast<std::int32_t>(random.integer(-reach - (reach > (1ll << 30) ? 1 : 0), reach));
            std::vector<std::int32_t> out(static_cast<std::size_t>((m - 1) * (m - 1)));
            predict_centres(k.data(), m, Order::four, out.data());
            for (int i = 0; i < m - 1; ++i)
                for (int j = 0; j < m - 1; ++j)
                    ASSERT_EQ(out[static_cast<std::size_t>(i * (m - 1) + j)], predicted(k, m, i, j))
                        << m << ' ' << i << ' ' << j;
        }
}

TEST(Predict, VectorsGiveWhatThePlainLoopGivesForEveryOrder) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const Order order : {Order::two, Order::four, Order::six})
        for (const int m : {4, 5, 6, 7, 8, 9, 16, 17, 33, 64, 65, 128, 129})
            for (const std::int64_t reach : {3ll, 1ll << 20, (1ll << 31) - 1}) {
                std::vector<std::int32_t> k(static_cast<std::size_t>(m * m));
                for (auto& x : k) x = static_cast<std::int32_t>(random.integer(-reach - 1, reach));
                std::vector<std::int32_t> plain(static_cast<std::size_t>((m - 1) * (m - 1))), fast(plain);
                predict_centres_plain(k.data(), m, order, plain.data());
                predict_centres(k.data(), m, order, fast.data());
                ASSERT_EQ(fast, plain) << static_cast<int>(order) << ' ' << m << ' ' << reach;
            }
}

TEST(Predict, OrderSixReproducesQuinticsInside) {
    // Exact on polynomials of degree 5; integer coefficients, even arguments: centres are integers.
    const int m = 12;
    const auto f = [](std::int64_t x, std::int64_t y) {
        return static_cast<std::int32_t>(x * x * x * x * x - 3 * x * x * x * y * y + 2 * x * y * y * y * y +
                                         5 * y * y * y - 7 * x * y);
    };
    std::vector<std::int32_t> k(144), out(121);
    for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j) k[static_cast<std::size_t>(i * m + j)] = f(2 * i, 2 * j);
    predict_centres(k.data(), m, Order::six, out.data());
    for (int i = 2; i < m - 3; ++i)
        for (int j = 2; j < m - 3; ++j)
            ASSERT_EQ(out[static_cast<std::size_t>(i * 11 + j)], f(2 * i + 1, 2 * j + 1)) << i << ' ' << j;
}

TEST(Predict, ReproducesCubicsInsideAndCubicsAlongBorders) {
    // Order 4: exact on polynomials of degree 3. Scaled by 64 so that centres are integers.
    const int m = 9;
    const auto f = [](int x, int y) {  // index position (x/2, y/2), times 64
        return 8 * x * x * x - 24 * x * x * y / 2 * 2 + 16 * x * y * y - 8 * y * y * y + 32 * x * y - 64 * x +
               128 * y + 640;
    };
    std::vector<std::int32_t> k(81), out(64);
    for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j) k[static_cast<std::size_t>(i * m + j)] = f(2 * i, 2 * j);
    predict_centres(k.data(), m, Order::four, out.data());
    for (int i = 1; i < m - 2; ++i)
        for (int j = 1; j < m - 2; ++j)
            ASSERT_EQ(out[static_cast<std::size_t>(i * 8 + j)], f(2 * i + 1, 2 * j + 1)) << i << ' ' << j;
    const auto g = [](int x, int y) { return 64 * x * x * x / 8 - 32 * x * x + 640 * y; };  // linear across
    for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j) k[static_cast<std::size_t>(i * m + j)] = g(2 * j, 2 * i);
    predict_centres(k.data(), m, Order::four, out.data());
    for (const int i : {0, 7})
        for (int j = 1; j < 7; ++j)
            ASSERT_EQ(out[static_cast<std::size_t>(i * 8 + j)], g(2 * j + 1, 2 * i + 1)) << i << ' ' << j;
}

TEST(Predict, ExtremesStayExactBeforeTheReduction) {
    for (const std::int32_t x : {kLeast, kMost}) {
        const std::vector<std::int32_t> k(17 * 17, x);
        std::vector<std::int32_t> out(16 * 16);
        predict_centres(k.data(), 17, Order::four, out.data());
        for (const std::int32_t y : out) ASSERT_EQ(y, x);  // int32 sums would have overflowed
    }
}

// ---- quantiser ----

TEST(Quantize, ErrorIsAtMostTheRadiusForAllOfInt32) {
    Random random;
    SCOPED_TRACE(random.trace());
    const auto check = [](std::int32_t residual, std::int32_t radius) {
        const std::int32_t index = quantize(residual, radius);
        const std::int64_t exact = std::int64_t{index} * (2 * std::int64_t{radius} + 1);
        ASSERT_LE(std::abs(residual - exact), radius) << residual << ' ' << radius;
        ASSERT_EQ(dequantize(index, radius), static_cast<std::int32_t>(static_cast<std::uint32_t>(exact)));
    };
    for (const std::int32_t radius : {0, 1, 2, 7, 127, 1 << 16, (1 << 29) - 1, 1 << 29})
        for (const std::int32_t residual : {kLeast, kLeast + 1, -1, 0, 1, kMost - 1, kMost})
            check(residual, radius);
    for (int k = 0; k < 200000; ++k)
        check(static_cast<std::int32_t>(random.bits() >> random.integer(0, 31)),
              static_cast<std::int32_t>(random.bits() % ((1u << random.integer(0, 29)) + 1)));
    for (int residual = -60; residual <= 60; ++residual)
        for (int radius = 0; radius < 12; ++radius) check(residual, radius);
}

TEST(Quantize, RadiusIsTheGreatestThatKeepsTheTolerance) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int k = 0; k < 100000; ++k) {
        const double quantum = std::exp2(random.real(-20, 4)),
                     tolerance = quantum * std::exp2(random.real(-1, 28));
        const std::int32_t r = quantizer_radius(tolerance, quantum);
        ASSERT_LE(r * quantum + quantum / 2, tolerance);
        ASSERT_GT((r + 1) * quantum + quantum / 2, tolerance * (1 - 1e-14)) << tolerance << ' ' << quantum;
    }
    EXPECT_EQ(quantizer_radius(1, 1.0 / 8), 7);
    EXPECT_EQ(quantizer_radius(0.5, 1), 0);
    EXPECT_EQ(quantizer_radius(16.5, 1), 16);
}

TEST(Quantize, RefusesImpossibleTolerances) {
    const double nan = std::nan(""), inf = std::numeric_limits<double>::infinity();
    for (const auto& [tolerance, quantum] : std::vector<std::pair<double, double>>{
             {0.49, 1}, {0, 1}, {-1, 1}, {1, 0}, {1, -1}, {nan, 1}, {1, nan}, {inf, 1}, {1, inf}})
        EXPECT_EQ(code_of([t = tolerance, q = quantum] { quantizer_radius(t, q); }), ErrorCode::usage);
    EXPECT_EQ(code_of([] { quantizer_radius(1e10, 1); }), ErrorCode::limit);
}

TEST(Quantize, DefaultQuantumIsAPowerOfTwoAndSmallEnough) {
    for (const double tolerance : {1e-6, 0.001, 0.01, 0.03124, 0.03125, 0.5, 1.0, 16.0, 1e6}) {
        const double q = default_quantum(tolerance);
        EXPECT_EQ(q, std::exp2(std::round(std::log2(q))));
        EXPECT_LE(q, std::min(1.0 / 256, tolerance / 8));
        EXPECT_GT(2 * q, std::min(1.0 / 256, tolerance / 8));
    }
}

// ---- bits and bytes ----

TEST(Bits, WhatWasPutComesBack) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (int round = 0; round < 200; ++round) {
        std::vector<std::pair<std::uint64_t, int>> words(static_cast<std::size_t>(random.integer(0, 300)));
        BitWriter out;
        for (auto& [value, count] : words) {
            count = static_cast<int>(random.integer(0, 55));
            value = random.bits() & ((std::uint64_t{1} << count) - 1);
            out.put(value, count);
        }
        const std::vector<std::byte> bytes = out.finish();
        BitReader in(bytes);
        for (const auto& [value, count] : words) {
            in.refill();
            ASSERT_EQ(in.take(count), value);
        }
        in.finish();
    }
}

TEST(Bits, ReadingPastTheEndIsTruncatedAndLeftoversAreCorrupt) {
    const std::vector<std::byte> two(2, std::byte{0});
    BitReader past(two);
    past.refill();
    past.take(17);
    EXPECT_EQ(code_of([&] { past.finish(); }), ErrorCode::truncated);
    BitReader early(two);
    early.refill();
    early.take(8);  // a whole byte left
    EXPECT_EQ(code_of([&] { early.finish(); }), ErrorCode::corrupt);
    const std::vector<std::byte> filled{std::byte{0x80}};
    BitReader ones(filled);
    ones.refill();
    ones.take(7);
    EXPECT_EQ(code_of([&] { ones.finish(); }), ErrorCode::corrupt);
    BitReader empty({});
    empty.refill();
    EXPECT_FALSE(empty.overrun());
    empty.finish();
}

TEST(Bytes, VarintsAreShortestAndBelow2To32) {
    const auto read = [](std::vector<int> raw) {
        std::vector<std::byte> bytes;
        for (const int b : raw) bytes.push_back(static_cast<std::byte>(b));
        ByteParser in(bytes, "varint");
        return in.varint();
    };
    for (const std::uint64_t x : {0ull, 1ull, 127ull, 128ull, 16383ull, 16384ull, 0xFFFFFFFFull}) {
        std::vector<std::byte> bytes;
        put_varint(bytes, x);
        ByteParser in(bytes, "varint");
        EXPECT_EQ(in.varint(), x);
        EXPECT_EQ(in.left(), 0u);
    }
    EXPECT_EQ(code_of([&] { read({0x80, 0x00}); }), ErrorCode::corrupt);
    EXPECT_EQ(code_of([&] { read({0xFF, 0xFF, 0xFF, 0xFF, 0x1F}); }), ErrorCode::corrupt);
    EXPECT_EQ(code_of([&] { read({0x80, 0x80, 0x80, 0x80, 0x80, 0x01}); }), ErrorCode::corrupt);
    EXPECT_EQ(code_of([&] { read({0x80}); }), ErrorCode::truncated);
    EXPECT_EQ(code_of([&] { read({}); }), ErrorCode::truncated);
}

// ---- gamma ----

std::string bit_text(std::int32_t value) {
    BitWriter out;
    put_gamma(out, value);
    const auto bytes = out.finish();
    std::string text;
    for (const std::byte b : bytes)
        for (int k = 0; k < 8; ++k) text += (static_cast<int>(b) >> k & 1) != 0 ? '1' : '0';
    return text.substr(0, text.find('1') * 2 + 1);
}

TEST(Gamma, CodesAreThoseOfTheSpecification) {
    EXPECT_EQ(bit_text(0), "1");
    EXPECT_EQ(bit_text(-1), "010");
    EXPECT_EQ(bit_text(1), "011");
    EXPECT_EQ(bit_text(-2), "00100");
    EXPECT_EQ(bit_text(2), "00110");
    EXPECT_EQ(bit_text(-3), "00101");
    EXPECT_EQ(bit_text(3), "00111");
    EXPECT_EQ(bit_text(kLeast), std::string(32, '0') + "1" + std::string(32, '0'));
}

TEST(Gamma, EveryKindOfInt32RoundTrips) {
    Random random;
    SCOPED_TRACE(random.trace());
    std::vector<std::int32_t> values{kLeast, kMost, kLeast + 1, kMost - 1, 0};
    for (int b = 0; b < 31; ++b)
        for (const int d : {-1, 0, 1}) {
            values.push_back((1 << b) + d);
            values.push_back(-(1 << b) + d);
        }
    for (int k = 0; k < 20000; ++k)
        values.push_back(static_cast<std::int32_t>(random.bits()) >> random.integer(0, 31));
    BitWriter out;
    for (const std::int32_t v : values) put_gamma(out, v);
    const auto bytes = out.finish();
    BitReader in(bytes);
    for (const std::int32_t v : values) ASSERT_EQ(take_gamma(in), v);
    in.finish();
}

TEST(Gamma, CodesOfNoInt32AreCorruptAndMissingBitsTruncated) {
    for (const int zeros : {33, 34, 40, 55}) {
        BitWriter out;
        out.put(std::uint64_t{1} << zeros, 56);
        out.put(0x1234567, 56);
        const auto bytes = out.finish();
        BitReader in(bytes);
        EXPECT_EQ(code_of([&] { take_gamma(in); }), ErrorCode::corrupt) << zeros;
    }
    BitWriter above;  // x = 2^32 + 1
    above.put(std::uint64_t{1} << 32, 33);
    above.put(1, 32);
    const auto bytes = above.finish();
    BitReader in(bytes);
    EXPECT_EQ(code_of([&] { take_gamma(in); }), ErrorCode::corrupt);
    const std::vector<std::byte> zeros(40);
    const std::vector<std::byte> zeros_only(zeros.begin(), zeros.begin() + 3);
    BitReader none{zeros_only};
    EXPECT_EQ(code_of([&] { take_gamma(none); }), ErrorCode::truncated);
}

std::vector<std::int32_t> sparse_matrix(Random& random, int rows, double density) {
    std::vector<std::int32_t> out(static_cast<std::size_t>(rows * rows));
    for (auto& x : out)
        if (random.chance(density)) x = static_cast<std::int32_t>(random.bits()) >> random.integer(0, 31);
    return out;
}

TEST(Gamma, MatricesRoundTripAndCostIsExact) {
    Random random;
    GammaReader reader;
    GammaWriter writer;
    SCOPED_TRACE(random.trace());
    for (const int side : {4, 8, 16, 32, 64, 128})
        for (const int rows : {side, side - 1})
            for (const int leaf : {2, 4})
                for (const double density : {0.0, 0.001, 0.05, 0.5, 1.0}) {
                    const auto values = sparse_matrix(random, rows, density);
                    writer.open();
                    writer.add(values, rows, side, leaf);
                    const auto bytes = writer.finish();
                    const std::uint64_t cost = writer.cost(values, rows, side, leaf);
                    ASSERT_EQ(bytes.size(), (cost + 7) / 8);
                    std::vector<std::int32_t> back(values.size(), 12345);
                    reader.open(bytes);
                    reader.read(rows, side, leaf, back);
                    reader.finish();
                    ASSERT_EQ(back, values);
                }
}

TEST(Gamma, AnEmptyMatrixIsOneBit) {
    const std::vector<std::int32_t> zeros(64 * 64);
    EXPECT_EQ(GammaWriter().cost(zeros, 64, 64, 2), 1u);
}

TEST(BlobInfo, EveryByteIsReadBackOrRefused) {
    for (int byte = 0; byte < 256; ++byte) {
        const auto b = static_cast<std::uint8_t>(byte);
        if ((byte & 3) == 3 || (byte >> 3 & 3) == 3 || byte >= 64)
            EXPECT_EQ(code_of([b] { BlobInfo::from_byte(b); }), ErrorCode::corrupt);
        else
            EXPECT_EQ(BlobInfo::from_byte(b).to_byte(), b);
    }
}

}  // namespace
}  // namespace carat::test
