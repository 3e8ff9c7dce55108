// Whole small repositories: what comes back is what the encoder saw, and it keeps every promise of the
// header.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>

#include "carat/codec/quantize.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "mini_builder.hpp"

namespace carat::test {
namespace {

struct Plan {
    std::string name;
    MiniPlan plan;
};

Mode any_mode(DiamondId d) { return static_cast<Mode>(DiamondIdHash{}(d) % 3); }

// A patch that reaches over a cube edge and down to the given level.
std::function<bool(DiamondId)> patch() {
    return [](DiamondId d) {
        const LatticePoint c = d.centre();
        const std::int64_t s = half_size(d.level());
        return c.x > kLatticeExtent - 3 * s && c.y > kLatticeExtent - 3 * s &&
               std::abs(c.z - kLatticeExtent / 3) < 2 * s;
    };
}

std::vector<Plan> plans() {
    std::vector<Plan> out;
    const std::array<const char*, 4> names{"mode0", "mode1", "mode2", "mixed"};
    for (int mode = 0; mode < 4; ++mode)
        for (const double tolerance : {0.001, 1.0, 100.0}) {
            MiniPlan p;
            p.quantum = default_quantum(tolerance);
            p.tolerance = tolerance;
            p.depth = 4;
            if (mode == 3)
                p.mode = any_mode;
            else
                p.mode = [mode](DiamondId) { return static_cast<Mode>(mode); };
            const auto amplitude = static_cast<std::int32_t>(std::min(9000 / p.quantum, 1e9));
            for (const NamedField& f : all_fields(amplitude, 24)) {
                p.source = f.field;
                out.push_back({f.name + " " + names[static_cast<std::size_t>(mode)] + " " +
                                   std::to_string(tolerance) + " m",
                               p});
            }
        }
    MiniPlan deep;
    deep.source = fractal(2000 * 256, 29, 20);
    deep.depth = 17;
    deep.refine = patch();
    deep.mode = any_mode;
    out.push_back({"patch", deep});
    deep.mode = {};
    deep.depth = 22;
    out.push_back({"deep patch", deep});
    deep.log2_cells = 2;
    out.push_back({"deep patch of tiny cells", deep});
    return out;
}

void expect_equal(const RefinedHeights& a, const RefinedHeights& b) {
    EXPECT_EQ(a.n, b.n);
    EXPECT_TRUE(a.v == b.v);
    EXPECT_TRUE(a.c == b.c);
}

class EveryPlan : public ::testing::TestWithParam<Plan> {};

TEST_P(EveryPlan, DecodesToWhatTheEncoderReconstructed) {
    const MiniBuild b = build_mini(GetParam().plan);
    const auto repository = b.open();
    const RepositoryHeader& h = repository->header();
    EXPECT_EQ(h.refined_diamonds, b.refined.size());
    EXPECT_EQ(h.deepest_level, static_cast<int>(b.levels.size()) - 1);
    EXPECT_EQ(repository->file_bytes(), b.bytes.size());
    const Surface surface(repository);
    for (const auto& [d, heights] : b.p) {
        EXPECT_EQ(repository->refined(d), b.refined.contains(d)) << to_string(d);
        const auto read = surface.heights(d);
        EXPECT_EQ(read->has_half, heights.has_half);
        for (int side = 0; side < 2; ++side)
            if (heights.has_half[static_cast<std::size_t>(side)])
                for_half(h.n(), side,
                         [&](int i, int j) { ASSERT_EQ(read->at(i, j), heights.at(i, j)) << to_string(d); });
        if (b.refined.contains(d)) expect_equal(*surface.refined_heights(d), b.reconstructed.at(d));
        for (const DiamondId k : children(d)) EXPECT_EQ(repository->refined(k), b.refined.contains(k));
    }
}

std::string name_of(const ::testing::TestParamInfo<Plan>& info) {
    std::string s = std::to_string(info.index) + "_" + info.param.name;
    for (char& c : s)
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
    return s;
}

INSTANTIATE_TEST_SUITE_P(Mini, EveryPlan, ::testing::ValuesIn(plans()), name_of);

}  // namespace
}  // namespace carat::test
