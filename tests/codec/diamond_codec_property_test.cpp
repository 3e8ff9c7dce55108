// Residual coding of one diamond, all modes: every value within the radius of its reference, decoding repeats
// encoding bit for bit, coding what was decoded changes nothing, and any bytes at all decode or are refused.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "carat/codec/diamond_codec.hpp"
#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/error.hpp"
#include "fields.hpp"
#include "globe/random.hpp"
#include "mini_builder.hpp"

namespace carat::test {
namespace {

constexpr std::array<Mode, 3> kModes{Mode::interpolating, Mode::filtered, Mode::paper};

std::vector<Coding> codings() { return {Coding{}, Coding::gamma(), Coding::paper()}; }

// A diamond's vertices and centres sampled from a field on face 0, spacing 2^16 lattice units.
RefinedHeights sampled(const Field& field, int n) {
    RefinedHeights r{n, Grid(static_cast<std::size_t>(n * n)),
                     Grid(static_cast<std::size_t>((n - 1) * (n - 1)))};
    const auto at = [&](int i2, int j2) {
        return field({static_cast<std::int32_t>(kLatticeExtent), (i2 << 15) - (1 << 21), (j2 << 15) + 12345});
    };
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) {
            r.v[static_cast<std::size_t>(i * n + j)] = at(2 * i, 2 * j);
            if (i < n - 1 && j < n - 1)
                r.c[static_cast<std::size_t>(i * (n - 1) + j)] = at(2 * i + 1, 2 * j + 1);
        }
    return r;
}

// The P an encoder would have: the reference P within the radius of it.
Grid coarse_vertices(const RefinedHeights& reference, Mode mode, std::int32_t radius, Random& random) {
    Grid p = reference.v;
    if (mode != Mode::interpolating) filter_vertices(reference, p);
    for (auto& x : p) x += static_cast<std::int32_t>(random.integer(-radius, radius));
    return p;
}

bool border(int n, std::size_t at) {
    const int i = static_cast<int>(at) / n, j = static_cast<int>(at) % n;
    return i == 0 || j == 0 || i == n - 1 || j == n - 1;
}

void expect_within(const RefinedHeights& out, const RefinedHeights& reference, const Grid& p, Mode mode,
                   std::int32_t radius) {
    const auto distance = [](std::int32_t a, std::int32_t b) { return std::abs(std::int64_t{a} - b); };
    for (std::size_t k = 0; k < out.c.size(); ++k) ASSERT_LE(distance(out.c[k], reference.c[k]), radius) << k;
    for (std::size_t k = 0; k < out.v.size(); ++k) {
        if (mode == Mode::interpolating || border(out.n, k))
            ASSERT_EQ(out.v[k], p[k]) << k;
        else
            ASSERT_LE(distance(out.v[k], reference.v[k]), radius) << k;
    }
}

// No residual, and none rounded to the step, can leave int32: |V - (2P - pred(C))| <= (1 + 2 + 3/2) * the
// greatest height.
bool residuals_fit(const RefinedHeights& reference, const Grid& p, std::int32_t radius) {
    std::int64_t greatest = 0;
    for (const Grid* g : {&reference.v, &reference.c, &p})
        for (const std::int32_t x : *g) greatest = std::max(greatest, std::abs(std::int64_t{x}));
    return 9 * (greatest + radius) / 2 + radius < (std::int64_t{1} << 31);
}

TEST(DiamondCodec, KeepsTheRadiusDecodesExactlyAndIsStable) {
    Random random;
    SCOPED_TRACE(random.trace());
    CodecScratch scratch;
    int stable = 0;
    for (const int n : {5, 9, 17, 65})
        for (const std::int32_t radius : {0, 1, 5, 255, 100000, 1 << 29})
            for (const NamedField& f : all_fields(std::max(3 * std::min(radius, 1 << 28), 1000), 16))
                for (int k = 0; k < 9; ++k) {
                    const Mode mode = kModes[static_cast<std::size_t>(k % 3)];
                    const Coding coding = codings()[static_cast<std::size_t>(k / 3)];
                    SCOPED_TRACE(std::string(to_string(coding.coder)) + " " + f.name + " n " +
                                 std::to_string(n) + " radius " + std::to_string(radius) + " mode " +
                                 std::to_string(static_cast<int>(mode)));
                    const RefinedHeights reference = sampled(f.field, n);
                    const Grid p = coarse_vertices(reference, mode, radius, random);
                    RefinedHeights out, back, again;
                    const EncodedResiduals e =
                        encode_residuals(coding, mode, p, reference, radius, out, scratch);
                    expect_within(out, reference, p, mode, radius);
                    decode_residuals(coding, e.info, e.blob, p, n, radius, back, scratch);
                    ASSERT_EQ(back.v, out.v);
                    ASSERT_EQ(back.c, out.c);
                    if (!residuals_fit(reference, p, radius)) continue;
                    ++stable;
                    Coding same = coding;  // other orders would not predict what this one reconstructed
                    same.orders = 1u << static_cast<unsigned>(e.info.order);
                    const EncodedResiduals e2 = encode_residuals(same, mode, p, out, radius, again, scratch);
                    ASSERT_EQ(e2.blob, e.blob);
                    ASSERT_EQ(e2.info.to_byte(), e.info.to_byte());
                    ASSERT_EQ(again.v, out.v);
                    ASSERT_EQ(again.c, out.c);
                }
    EXPECT_GT(stable, 900);
}

TEST(DiamondCodec, PerfectPredictionStoresNothing) {
    CodecScratch scratch;
    const RefinedHeights reference =
        sampled([](const LatticePoint& q) { return (q.y >> 12) + 2 * (q.z >> 12); }, 17);
    RefinedHeights out;
    for (const Coding& coding : codings()) {
        const auto e = encode_residuals(coding, Mode::interpolating, reference.v, reference, 1, out, scratch);
        EXPECT_TRUE(e.blob.empty());
        EXPECT_EQ(e.info, BlobInfo{});  // what a zero page stands for
    }
}

TEST(DiamondCodec, FilteredVerticesAreTheMeanOfVertexAndPrediction) {
    const RefinedHeights r = sampled(extreme(), 17);
    Grid p(17 * 17), predicted(15 * 15);
    filter_vertices(r, p);
    predict_centres(r.c.data(), 16, Order::four, predicted.data());
    for (int i = 0; i < 17; ++i)
        for (int j = 0; j < 17; ++j) {
            const auto at = static_cast<std::size_t>(i * 17 + j);
            if (border(17, at)) {
                EXPECT_EQ(p[at], r.v[at]);
                continue;
            }
            const double mean =
                (static_cast<double>(r.v[at]) + predicted[static_cast<std::size_t>((i - 1) * 15 + j - 1)]) /
                2;
            EXPECT_EQ(p[at], std::clamp(std::floor(mean + 0.5), -0x1p30, 0x1p30));
        }
}

TEST(DiamondCodec, HostileVerticesAndReferencesStillDecodeAsEncoded) {
    Random random;
    SCOPED_TRACE(random.trace());
    CodecScratch scratch;
    for (int round = 0; round < 300; ++round) {
        const int n = round % 2 == 0 ? 9 : 17;
        const auto radius = static_cast<std::int32_t>(random.bits() % ((1u << random.integer(0, 29)) + 1));
        const auto any = [&] { return static_cast<std::int32_t>(random.bits()); };
        RefinedHeights reference{n, Grid(static_cast<std::size_t>(n * n)),
                                 Grid(static_cast<std::size_t>((n - 1) * (n - 1)))};
        Grid p(reference.v.size());
        for (Grid* g : {&reference.v, &reference.c, &p})
            for (auto& x : *g) x = any();
        for (int way = 0; way < 9; ++way) {
            const Mode mode = kModes[static_cast<std::size_t>(way % 3)];
            const Coding coding = codings()[static_cast<std::size_t>(way / 3)];
            RefinedHeights out, back;
            const EncodedResiduals e = encode_residuals(coding, mode, p, reference, radius, out, scratch);
            decode_residuals(coding, e.info, e.blob, p, n, radius, back, scratch);
            ASSERT_EQ(back.v, out.v);
            ASSERT_EQ(back.c, out.c);
            for (std::size_t k = 0; k < out.c.size(); ++k) {  // the promise holds modulo 2^32
                const std::int32_t error = wrapping_sub(out.c[k], reference.c[k]);
                ASSERT_LE(std::abs(std::int64_t{error}), radius);
            }
            Grid filtered(p.size());
            filter_vertices(reference, filtered);
        }
    }
}

TEST(DiamondCodec, AnyBytesDecodeOrAreRefused) {
    Random random;
    SCOPED_TRACE(random.trace());
    CodecScratch scratch;
    int decoded = 0, refused = 0;
    for (int round = 0; round < 30000; ++round) {
        const int n = (1 << random.integer(2, 5)) + 1;
        const auto radius = static_cast<std::int32_t>(random.bits() % ((1u << random.integer(0, 29)) + 1));
        Grid p(static_cast<std::size_t>(n * n));
        for (auto& x : p) x = static_cast<std::int32_t>(random.bits());
        std::vector<std::byte> blob(static_cast<std::size_t>(random.integer(0, round % 3 == 0 ? 4 : 60)));
        const auto ones = random.bits() | random.bits();  // few long runs of zeros: most codes are short
        for (auto& b : blob)
            b = static_cast<std::byte>(round % 2 == 0 ? random.bits() : random.bits() | ones);
        const BlobInfo info{kModes[static_cast<std::size_t>(round % 3)], round % 5 < 2 ? 2 : 4,
                            round % 4 == 3, static_cast<Order>(round % 7 % 3)};
        const Coding coding = codings()[static_cast<std::size_t>(round % 2)];
        RefinedHeights out;
        try {
            decode_residuals(coding, info, blob, p, n, radius, out, scratch);
            ++decoded;
        } catch (const Error& e) {
            ASSERT_TRUE(e.code() == ErrorCode::corrupt || e.code() == ErrorCode::truncated) << e.what();
            ++refused;
        }
    }
    EXPECT_GT(decoded, 1000);
    EXPECT_GT(refused, 1000);
}

}  // namespace
}  // namespace carat::test
