// Files of format version 4, written once and kept: both readers find the pinned heights in them, for ever.
#include "golden.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <thread>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/surface.hpp"
#include "carat/codec/verify.hpp"
#include "census.hpp"
#include "mini_builder.hpp"
#include "range_kernels.hpp"
#include "slow_reader.hpp"
#include "walk.hpp"

namespace carat::test {
namespace {

const std::filesystem::path kFolder = std::filesystem::path(CARAT_SOURCE_DIR) / "tests/codec/golden";

Mode any_mode(DiamondId d) { return static_cast<Mode>((d.bits() / 7) % 3); }

std::function<bool(DiamondId)> patch(int depth) {
    return [depth](DiamondId d) {
        const LatticePoint c = d.centre();
        const std::int64_t s = half_size(d.level());
        return d.level() < depth && c.y > kLatticeExtent - 2 * s && c.z > kLatticeExtent - 2 * s &&
               std::abs(c.x - kLatticeExtent / 7) < s;
    };
}

// As --fit-tables does: counted in a build with the built-in ones.
std::shared_ptr<const RangeTables> tables_fitted_to(MiniPlan p) {
    RangeStatistics counts;
    p.statistics = &counts;
    build_mini(p);
    return RangeTables::fit(counts);
}

// Patches of the default size, N = 65: face 0 and three diamonds on its sides, one of each mode and order.
// Roots are flat but for what filters bring there; the centres of face 0 are so rough that their code is
// long.
void plan_default_patches(MiniPlan& p) {
    const auto kind = [](DiamondId d) {
        const LatticePoint c = d.centre();
        return d.level() == 0 || c.y > 0 ? 0 : c.y < 0 ? 1 : 2;
    };
    p.log2_cells = 6;
    p.depth = 2;
    p.tolerance = 1;
    p.refine = [](DiamondId d) {
        const auto sides = children(root_diamond(0));
        return d.level() == 0 ? d == root_diamond(0)
                              : std::find(sides.begin(), sides.end(), d) != sides.end() && d.centre().z >= 0;
    };
    p.mode = [kind](DiamondId d) { return static_cast<Mode>(kind(d)); };
    p.orders = [kind](DiamondId d) { return 0b100u >> kind(d); };
    p.source = [rough = white_noise(1 << 19),
                gentle = fractal(200 * 256, 27, 12)](const LatticePoint& q) -> std::int32_t {
        const auto on = [&q](std::int32_t spacing) { return q.y % spacing == 0 && q.z % spacing == 0; };
        if (q.x != kLatticeExtent || on(1 << 25)) return 0;
        return on(1 << 24) ? rough(q) : gentle(q);
    };
}

MiniPlan plan_of(const std::string& file) {
    MiniPlan p;
    p.provenance = "{\"golden\":\"" + file + "\"}";
    p.vertical_datum = "ellipsoid";
    p.source = fractal(700 * 256, 28, 12);
    p.log2_cells = 3;
    p.tolerance = 30;
    if (file == "example.carat") {  // docs/format.md, section 14
        p.log2_cells = 2;
        p.depth = 1;
        p.quantum = 0.125;
        p.tolerance = 1;
        p.refine = [](DiamondId d) { return d.face() == 0; };
        p.body = Ellipsoid::moon();
        p.vertical_datum = "unstated";
        p.provenance = "{}";
        constexpr std::int32_t quarter = 1 << 28;  // the centre of cell (2, 2) of face 0
        p.source = [](const LatticePoint& q) {
            return q == LatticePoint{1 << 30, quarter, quarter} ? 150 : 0;
        };
    } else if (file == "mixed_modes.carat" || file == "range.carat" || file == "fitted.carat") {
        p.depth = 4;
        p.mode = any_mode;
        if (file != "mixed_modes.carat") p.coding = Coding{};
        if (file == "range.carat") p.log2_cells = 4;
        if (file == "fitted.carat") p.coding.tables = tables_fitted_to(p);
    } else if (file == "paper.carat") {
        p.log2_cells = 4;
        p.depth = 2;
        p.mode = [](DiamondId) { return Mode::paper; };
        p.body = Ellipsoid::mars();
    } else if (file == "default_gamma.carat" || file == "default_range.carat") {
        plan_default_patches(p);
        p.coding = file == "default_range.carat" ? Coding{} : Coding::gamma();
    } else if (file == "deep_patch.carat") {
        p.depth = 20;
        p.refine = patch(20);
        p.mode = any_mode;
        p.tolerance = 3;
        p.source = fractal(4000 * 256, 29, 25);
    } else {
        p.log2_cells = 2;
        p.depth = 7;
        p.tolerance = 1;
        p.source = [](const LatticePoint& q) {
            const auto near = [](std::int32_t x) { return std::abs(x - (1 << 29)) < 1 << 27; };
            const bool rough = q.x == kLatticeExtent && near(q.y) && near(q.z);
            return rough ? 99 + 200 * (q.y >> 24 & 15) : 99;
        };
        p.body = Ellipsoid::moon();
    }
    return p;
}

TEST(Golden, HeightsAreThePinnedOnes) {
    for (const Golden& g : kGolden)
        EXPECT_EQ(hash_heights(Repository::open(kFolder / g.file)), g.heights) << g.file;
}

// What a file holds that a decoder treats differently.
struct Kinds {
    std::set<Mode> modes;
    std::set<Order> orders;
    std::set<bool> gamma;
    int most_states = 0;
};

int states_of(std::span<const std::byte> matrix) {
    return matrix.empty() ? 0 : 1 << (static_cast<int>(matrix[0]) & 7);
}

Kinds kinds_in(const std::filesystem::path& file) {
    const auto source = open_file(file);
    const FileStructure structure(*source);
    Kinds kinds;
    for (const PartEntry& entry : structure.parts()) {
        const PagePart part = structure.part(entry);
        for (const PageDiamond& d : part.diamonds()) {
            kinds.modes.insert(d.info.mode);
            kinds.orders.insert(d.info.order);
            kinds.gamma.insert(d.info.gamma);
            if (d.info.gamma || structure.header().coding.coder == CoderId::gamma) continue;
            std::span<const std::byte> first = d.blob;
            if (d.info.mode != Mode::interpolating) {
                ByteParser in(d.blob, "blob");
                const std::size_t length = in.varint();
                first = in.take(length);
                kinds.most_states = std::max(kinds.most_states, states_of(in.take(in.left())));
            }
            kinds.most_states = std::max(kinds.most_states, states_of(first));
        }
    }
    return kinds;
}

TEST(Golden, DefaultPatchesTakeEveryWayOfTheDecoder) {
    for (const char* file : {"default_gamma.carat", "default_range.carat"}) {
        const Kinds kinds = kinds_in(kFolder / file);
        EXPECT_EQ(kinds.modes.size(), 3u) << file;
        EXPECT_EQ(kinds.orders.size(), 3u) << file;
    }
    EXPECT_EQ(kinds_in(kFolder / "default_range.carat").most_states, kMostStates);
}

TEST(Golden, VerifyFindsNoDamage) {
    for (const Golden& g : kGolden) {
        const VerifyReport report = verify_file(kFolder / g.file);
        EXPECT_TRUE(report.ok()) << g.file << ": " << (report.damage.empty() ? "" : report.damage.front());
        EXPECT_EQ(report.census.refined, Repository::open(kFolder / g.file)->header().refined_diamonds)
            << g.file;
    }
}

TEST(Golden, HeightsAreThePinnedOnesFromManyThreads) {
    for (const Golden& g : kGolden) {
        const auto repository = Repository::open(kFolder / g.file);
        std::array<std::uint64_t, 6> found{};
        std::vector<std::thread> threads;
        for (std::uint64_t& f : found)
            threads.emplace_back([&f, &repository] { f = hash_heights(repository); });
        for (std::thread& t : threads) t.join();
        for (const std::uint64_t f : found) EXPECT_EQ(f, g.heights) << g.file;
    }
}

// CARAT_WRITE_GOLDEN=1 also writes the files anew: only for a new version of the format.
TEST(Golden, TheEncoderStillReconstructsTheSameHeights) {
    for (const Golden& g : kGolden) {
        const MiniBuild b = build_mini(plan_of(g.file));
        EXPECT_EQ(hash_heights(b.open()), g.heights) << g.file;
        if (std::getenv("CARAT_WRITE_GOLDEN") != nullptr)
            std::ofstream(kFolder / g.file, std::ios::binary)
                .write(reinterpret_cast<const char*>(b.bytes.data()),
                       static_cast<std::streamsize>(b.bytes.size()));
    }
}

TEST(Golden, TheSlowReaderFindsThem) {
    for (const Golden& g : kGolden) {
        std::ifstream in(kFolder / g.file, std::ios::binary);
        const std::vector<char> chars{std::istreambuf_iterator<char>(in), {}};
        slow::Reader plain({chars.begin(), chars.end()});
        const Surface surface(Repository::open(kFolder / g.file));
        std::set<std::pair<int, DiamondId>> queue;
        for (int face = 0; face < kFaces; ++face) queue.insert({0, root_diamond(face)});
        int refined = 0;
        while (!queue.empty()) {
            const auto [level, d] = *queue.begin();
            queue.erase(queue.begin());
            const slow::Point c{d.centre().x, d.centre().y, d.centre().z};
            ASSERT_EQ(surface.repository().refined(d), plain.refined(c));
            if (!plain.refined(c)) continue;
            const auto fast = surface.refined_heights(d);
            const slow::Refined& r = plain.refine(c);
            ASSERT_TRUE(std::equal(r.v.begin(), r.v.end(), fast->v.begin(), fast->v.end()));
            ASSERT_TRUE(std::equal(r.c.begin(), r.c.end(), fast->c.begin(), fast->c.end()));
            for (const DiamondId k : children(d)) queue.insert({level + 1, k});
            ++refined;
        }
        EXPECT_EQ(static_cast<std::uint64_t>(refined), plain.header().refined);
    }
}

}  // namespace
}  // namespace carat::test
