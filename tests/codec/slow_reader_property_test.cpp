// The slow reader, written from docs/format.md, and the fast one agree on every bit of several small files
// that between them use all modes, both leaf sizes, split pages, zero pages and all sizes of patches.
#include <gtest/gtest.h>

#include "carat/codec/surface.hpp"
#include "mini_builder.hpp"
#include "slow_reader.hpp"

namespace carat::test {
namespace {

std::vector<std::uint8_t> plain_bytes(const std::vector<std::byte>& bytes) {
    std::vector<std::uint8_t> out;
    for (const std::byte b : bytes) out.push_back(static_cast<std::uint8_t>(b));
    return out;
}

slow::Point slow_point(const LatticePoint& p) { return {p.x, p.y, p.z}; }

Mode any_mode(DiamondId d) { return static_cast<Mode>(DiamondIdHash{}(d) % 3); }

void expect_header(const RepositoryHeader& fast, const slow::Header& plain) {
    EXPECT_EQ(fast.quantum, plain.quantum);
    EXPECT_EQ(fast.tolerance, plain.tolerance);
    EXPECT_EQ(fast.body_a, plain.a);
    EXPECT_EQ(fast.body_b, plain.b);
    EXPECT_EQ(fast.log2_cells, plain.p);
    EXPECT_EQ(fast.deepest_level, plain.deepest);
    EXPECT_EQ(fast.refined_diamonds, plain.refined);
    EXPECT_EQ(fast.min_height, plain.least);
    EXPECT_EQ(fast.max_height, plain.greatest);
    EXPECT_EQ(fast.body, plain.body);
    EXPECT_EQ(fast.vertical_datum, plain.datum);
    EXPECT_EQ(fast.provenance, plain.provenance);
}

bool same(const std::vector<std::int32_t>& fast, const slow::Matrix& plain) {
    return std::equal(fast.begin(), fast.end(), plain.begin(), plain.end());
}

void expect_refined(const Surface& surface, slow::Reader& plain, DiamondId d) {
    const slow::Point c = slow_point(d.centre());
    const auto fast = surface.refined_heights(d);
    const slow::Refined& expected = plain.refine(c);
    ASSERT_TRUE(same(fast->v, expected.v)) << to_string(d);
    ASSERT_TRUE(same(fast->c, expected.c)) << to_string(d);
    for (int side = 0; side < 2; ++side) {
        const HalfSummary s = surface.repository().summary({d, side});
        const slow::Summary t = plain.summary(c, side);
        const double q = plain.header().quantum;
        EXPECT_EQ(s.min_height, q * static_cast<double>(t.least)) << to_string(d);
        EXPECT_EQ(s.max_height, q * static_cast<double>(t.greatest)) << to_string(d);
        EXPECT_EQ(s.delta, t.delta) << to_string(d);
    }
}

void expect_heights(const Surface& surface, slow::Reader& plain, DiamondId d) {
    const auto fast = surface.heights(d);
    const slow::Heights& expected = plain.heights(slow_point(d.centre()));
    ASSERT_EQ(fast->has_half, expected.has) << to_string(d);
    for (int side = 0; side < 2; ++side)
        if (expected.has[static_cast<std::size_t>(side)])
            for_half(plain.n(), side, [&](int i, int j) {
                ASSERT_EQ(fast->at(i, j), expected.p[static_cast<std::size_t>(i * plain.n() + j)])
                    << to_string(d);
            });
}

// Returns what the file holds, for tests to see that it is the file they meant.
slow::Reader::Count expect_agreement_of(const MiniPlan& plan) {
    const MiniBuild b = build_mini(plan);
    slow::Reader plain(plain_bytes(b.bytes));
    const Surface surface(b.open());
    expect_header(surface.repository().header(), plain.header());
    EXPECT_EQ(plain.header().deepest, plan.depth);
    for (const auto& [d, heights] : b.p) {
        EXPECT_EQ(surface.repository().refined(d), plain.refined(slow_point(d.centre()))) << to_string(d);
        expect_heights(surface, plain, d);
        if (plain.refined(slow_point(d.centre()))) expect_refined(surface, plain, d);
        if (d.level() == kDeepestId) continue;
        for (const DiamondId k : children(d))
            EXPECT_EQ(surface.repository().refined(k), plain.refined(slow_point(k.centre()))) << to_string(k);
    }
    return plain.count();
}

slow::Reader::Count expect_agreement(MiniPlan plan) {
    plan.coding = Coding::gamma();
    expect_agreement_of(plan);
    plan.coding = Coding{};
    return expect_agreement_of(plan);
}

std::function<bool(DiamondId)> around_a_cube_edge() {
    return [](DiamondId d) {
        const LatticePoint c = d.centre();
        const std::int64_t s = half_size(d.level());
        return c.x < -kLatticeExtent + 2 * s && c.z < -kLatticeExtent + 2 * s &&
               std::abs(c.y + kLatticeExtent / 5) < 2 * s;
    };
}

TEST(SlowReader, AgreesInEveryModeAndPatchSize) {
    for (int p = 2; p <= 5; ++p)
        for (int mode = 0; mode < 4; ++mode) {
            SCOPED_TRACE("p " + std::to_string(p) + " mode " + std::to_string(mode));
            MiniPlan plan;
            plan.log2_cells = p;
            plan.depth = 9 - p;
            plan.source = fractal(3000 * 256, 29, 14);
            plan.tolerance = 4;
            plan.body = Ellipsoid::mars();
            plan.vertical_datum = "areoid";
            plan.provenance = "{\"layers\":[\"a\"]}";
            plan.mode = [mode](DiamondId d) { return mode == 3 ? any_mode(d) : static_cast<Mode>(mode); };
            expect_agreement(plan);
        }
}

TEST(SlowReader, AgreesOnTheDefaultPatchSize) {
    MiniPlan plan;
    plan.log2_cells = 6;
    plan.depth = 3;
    plan.source = fractal(3000 * 256, 29, 14);
    plan.mode = any_mode;
    expect_agreement(plan);
}

TEST(SlowReader, AgreesDeepDownAtACubeEdge) {
    for (const int p : {2, 4}) {
        MiniPlan plan;
        plan.log2_cells = p;
        plan.depth = 27;
        plan.refine = around_a_cube_edge();
        plan.source = fractal(3000 * 256, 29, 24);
        plan.mode = any_mode;
        expect_agreement(plan);
    }
}

TEST(SlowReader, AgreesAtTheDeepestLevel) {
    MiniPlan plan;
    plan.log2_cells = 2;
    plan.depth = 50;
    plan.refine = around_a_cube_edge();
    plan.source = fractal(3000 * 256, 29, 30);
    expect_agreement(plan);
}

TEST(SlowReader, AgreesOnSplitPages) {
    MiniPlan plan;
    plan.log2_cells = 6;
    plan.depth = 5;
    plan.refine = [](DiamondId d) { return d.face() <= 2; };
    plan.source = white_noise(1 << 28);
    plan.tolerance = 0.002;
    const slow::Reader::Count count = expect_agreement(plan);
    EXPECT_GT(count.parts, count.pages + 10);
}

TEST(SlowReader, AgreesOnZeroPages) {
    for (const int depth : {3, 6, 8, 13}) {
        MiniPlan plan;
        plan.log2_cells = 2;
        plan.depth = depth;
        plan.source = constant(-77);
        if (depth == 13) plan.refine = [](DiamondId d) { return d.face() == 3; };
        EXPECT_GE(expect_agreement(plan).zero_pages, 1) << depth;
    }
    MiniPlan island;  // rough in one place, zero elsewhere
    island.log2_cells = 3;
    island.depth = 9;
    island.source = [rough = fractal(400 * 256)](const LatticePoint& p) {
        return p.x == kLatticeExtent && std::abs(p.y - 300000000) < (1 << 26) && std::abs(p.z) < (1 << 26)
                   ? rough(p)
                   : 0;
    };
    const slow::Reader::Count count = expect_agreement(island);
    EXPECT_GT(count.zero_pages, 6);
    EXPECT_GT(count.pages, count.zero_pages);
}

}  // namespace
}  // namespace carat::test
