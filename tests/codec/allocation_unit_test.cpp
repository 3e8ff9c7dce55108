// The hot path allocates nothing: once warmed up, a decoded diamond 0 times, an encoded one once, its blob.
#include <gtest/gtest.h>

#include <string>

#include "allocation_watch.hpp"
#include "carat/codec/diamond_codec.hpp"
#include "globe/random.hpp"

namespace carat::test {
namespace {

constexpr int kN = 65;

RefinedHeights random_heights(Random& random, std::int64_t reach, double density) {
    RefinedHeights out{kN, std::vector<std::int32_t>(kN * kN),
                       std::vector<std::int32_t>((kN - 1) * (kN - 1))};
    for (auto* values : {&out.v, &out.c})
        for (auto& x : *values)
            if (random.chance(density)) x = static_cast<std::int32_t>(random.integer(-reach, reach));
    return out;
}

void expect_few(const Coding& coding, Mode mode, const RefinedHeights& reference, CodecScratch& scratch) {
    SCOPED_TRACE(std::string(to_string(coding.coder)) + " mode " + std::to_string(static_cast<int>(mode)));
    constexpr std::int32_t kRadius = 50;
    std::vector<std::int32_t> p(reference.v);
    RefinedHeights out = reference, back = reference;
    forget_allocations();
    if (mode != Mode::interpolating) filter_vertices(reference, p);
    EXPECT_EQ(allocations(), 0u);
    const EncodedResiduals e = encode_residuals(coding, mode, p, reference, kRadius, out, scratch);
    EXPECT_EQ(allocations(), e.blob.empty() ? 0u : 1u);
    EXPECT_EQ(largest_allocation(), e.blob.size());
    forget_allocations();
    decode_residuals(coding, e.info, e.blob, p, kN, kRadius, back, scratch);
    EXPECT_EQ(allocations(), 0u);
    EXPECT_EQ(back.c, out.c);
}

TEST(Allocation, DecodingTakesNoneAndEncodingOneForItsBlob) {
    Random random;
    SCOPED_TRACE(random.trace());
    const RefinedHeights rough = random_heights(random, 1 << 28, 1);
    // Dense, sparse (gamma beside range), and all zero.
    const RefinedHeights references[] = {rough, random_heights(random, 2000, 0.5),
                                         random_heights(random, 2000, 0.002), random_heights(random, 0, 0)};
    CodecScratch scratch;
    RefinedHeights out;
    for (const Coding& coding : {Coding{}, Coding::gamma()}) {
        const EncodedResiduals e = encode_residuals(coding, Mode::paper, rough.v, rough, 0, out, scratch);
        decode_residuals(coding, e.info, e.blob, rough.v, kN, 0, out, scratch);
    }
    for (const Coding& coding : {Coding{}, Coding::gamma(), Coding::paper()})
        for (const Mode mode : {Mode::interpolating, Mode::filtered, Mode::paper})
            for (const RefinedHeights& reference : references) expect_few(coding, mode, reference, scratch);
}

}  // namespace
}  // namespace carat::test
