// Damaged and hostile files: always a typed error or a right answer, and no allocation that the file's size
// does not justify. Meant to run under AddressSanitizer and UndefinedBehaviorSanitizer too.
#include <gtest/gtest.h>

#include <functional>
#include <iostream>
#include <map>
#include <set>

#include "allocation_watch.hpp"
#include "carat/codec/byte_source.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "census.hpp"
#include "checksum_repair.hpp"
#include "globe/random.hpp"
#include "mini_builder.hpp"
#include "slow_reader.hpp"
#include "walk.hpp"

namespace carat::test {
namespace {

using Bytes = std::vector<std::byte>;

constexpr int kWalk = 2000, kShortWalk = 250;  // diamonds looked at; a hostile zero page could stand for 2^50

// What a reader makes of bytes: a number, or the name of its error.
struct Outcome {
    std::uint64_t hash = 0;
    std::string refused, message;
};

Outcome read(const Bytes& bytes) {
    try {
        return {walk(Repository::open(bytes_in_memory(bytes, "damaged")), kWalk), "", ""};
    } catch (const Error& e) {
        return {0, to_string(e.code()), e.what()};
    }
}

Mode any_mode(DiamondId d) { return static_cast<Mode>(DiamondIdHash{}(d) % 3); }

MiniPlan small_plan() {
    MiniPlan p;
    p.log2_cells = 2;
    p.depth = 7;
    p.refine = [](DiamondId d) {
        return d.level() < 2 || (d.centre().x > kLatticeExtent / 2 && d.centre().y > 0 && d.centre().z > 0);
    };
    p.source = fractal(500 * 256);
    p.tolerance = 40;
    p.mode = any_mode;
    p.provenance = "{\"layers\":[]}";
    return p;
}

MiniPlan zero_plan() {  // zero pages beside pages with diamonds
    MiniPlan p;
    p.log2_cells = 2;
    p.depth = 8;
    p.source = [](const LatticePoint& q) {
        return q.x == kLatticeExtent && q.y > 0 && q.z > 0 ? (q.y ^ q.z) >> 21 : 5;
    };
    return p;
}

MiniPlan split_plan() {
    MiniPlan p;
    p.log2_cells = 5;
    p.depth = 6;
    p.refine = [](DiamondId d) { return d.face() == 0; };
    p.source = white_noise(1 << 29);
    p.tolerance = 0.002;
    return p;
}

std::string trace(const char* what, std::uint64_t at) {
    return std::string(what) + " at " + std::to_string(at);
}

// True if the damage was noticed.
bool expect_error_or_same(const Bytes& damaged, std::uint64_t intact, const std::string& where) {
    forget_allocations();
    const Outcome o = read(damaged);
    if (o.refused.empty())
        EXPECT_EQ(o.hash, intact) << where;
    else
        EXPECT_TRUE(o.refused == "corrupt" || o.refused == "truncated" || o.refused == "unsupported" ||
                    o.refused == "limit")
            << where << ": " << o.refused << ": " << o.message;
    EXPECT_LE(largest_allocation(), damaged.size() + (2u << 20)) << where;
    return !o.refused.empty();
}

TEST(Damage, TruncationAtEveryLengthIsRefused) {
    const Bytes whole = build_mini(small_plan()).bytes;
    std::cout << whole.size() << " bytes\n";
    for (std::size_t length = 0; length < whole.size(); ++length) {
        const Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
        const Outcome o = read(cut);
        ASSERT_EQ(o.refused, "truncated") << length << ": " << o.message;
        ASSERT_NE(o.message.find("damaged"), std::string::npos) << o.message;
    }
}

// The same with a header that owns up to the new length, and right checksums: the directory is missing then.
TEST(Damage, TruncationThatTheHeaderKnowsOfIsRefused) {
    const Bytes whole = build_mini(small_plan()).bytes;
    for (std::size_t length = 0; length < whole.size(); ++length) {
        Bytes cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length));
        for (std::size_t k = 0; k < 8 && 16 + k < length; ++k)
            cut[16 + k] = static_cast<std::byte>(length >> (8 * k));
        repair_checksums(cut);
        const Outcome o = read(cut);
        ASSERT_TRUE(o.refused == "truncated" || o.refused == "corrupt")
            << length << ": " << o.refused << o.message;
    }
}

TEST(Damage, BytesAfterTheEndAreRefused) {
    Bytes longer = build_mini(small_plan()).bytes;
    longer.push_back(std::byte{0});
    EXPECT_EQ(read(longer).refused, "corrupt");
}

TEST(Damage, SingleBitFlipsGiveAnErrorOrTheSameAnswer) {
    Random random;
    SCOPED_TRACE(random.trace());
    for (const auto& [plan, flips] :
         {std::pair{small_plan(), 6000}, {zero_plan(), 3800}, {split_plan(), 200}}) {
        const Bytes whole = build_mini(plan).bytes;
        const std::uint64_t intact = read(whole).hash;
        int unnoticed = 0;
        for (int k = 0; k < flips; ++k) {
            const auto bit = static_cast<std::uint64_t>(
                random.integer(0, static_cast<std::int64_t>(8 * whole.size()) - 1));
            Bytes damaged = whole;
            damaged[bit / 8] ^= static_cast<std::byte>(1u << (bit % 8));
            unnoticed += expect_error_or_same(damaged, intact, trace("bit", bit)) ? 0 : 1;
        }
        std::cout << whole.size() << " bytes, " << flips << " flips, " << unnoticed << " unnoticed\n";
        EXPECT_EQ(unnoticed, 0);  // every byte is under a checksum, and the walk reads every page
    }
}

// ---- Behind the checksums: both readers must agree on what to refuse and what to answer. ----

std::uint64_t slow_walk(const Bytes& bytes) {
    std::vector<std::uint8_t> plain;
    for (const std::byte b : bytes) plain.push_back(static_cast<std::uint8_t>(b));
    slow::Reader reader(std::move(plain));
    std::set<std::pair<int, DiamondId>> queue;
    for (int face = 0; face < kFaces; ++face) queue.insert({0, root_diamond(face)});
    std::uint64_t hash = 0;
    for (int budget = kShortWalk; !queue.empty() && budget > 0; --budget) {
        const auto [level, d] = *queue.begin();
        queue.erase(queue.begin());
        const LatticePoint c = d.centre();
        const slow::Point p{c.x, c.y, c.z};
        if (!reader.refined(p)) continue;
        const slow::Refined& r = reader.refine(p);
        for (const slow::Matrix* m : {&r.v, &r.c})
            for (const std::int64_t x : *m) hash = hash * 0x9E3779B97F4A7C15u + static_cast<std::uint64_t>(x);
        for (const DiamondId k : children(d)) queue.insert({level + 1, k});
    }
    return hash;
}

// The same number by the fast reader.
std::uint64_t fast_walk(const Bytes& bytes) {
    const auto repository = Repository::open(bytes_in_memory(bytes, "hostile"));
    const Surface surface(repository);
    std::set<std::pair<int, DiamondId>> queue;
    for (int face = 0; face < kFaces; ++face) queue.insert({0, root_diamond(face)});
    std::uint64_t hash = 0;
    for (int budget = kShortWalk; !queue.empty() && budget > 0; --budget) {
        const auto [level, d] = *queue.begin();
        queue.erase(queue.begin());
        if (!repository->refined(d)) continue;
        const auto r = surface.refined_heights(d);
        for (const Grid* m : {&r->v, &r->c})
            for (const std::int32_t x : *m)
                hash = hash * 0x9E3779B97F4A7C15u + static_cast<std::uint64_t>(static_cast<std::int64_t>(x));
        for (const DiamondId k : children(d)) queue.insert({level + 1, k});
    }
    return hash;
}

// Whether the fast reader refuses header, root values or directory when it reads all of them.
bool directory_is_refused(const Bytes& bytes) {
    try {
        const auto source = bytes_in_memory(bytes, "hostile");
        const FileStructure whole(*source);
        return false;
    } catch (const Error& e) {
        return e.code() == ErrorCode::corrupt || e.code() == ErrorCode::truncated;
    }
}

void expect_agreement(const Bytes& hostile, const std::string& where, std::map<std::string, int>& tally) {
    Outcome fast, plain;
    forget_allocations();
    try {
        fast.hash = fast_walk(hostile);
    } catch (const Error& e) {
        fast.refused = to_string(e.code());
        fast.message = e.what();
    }
    EXPECT_LE(largest_allocation(), hostile.size() + (2u << 20)) << where;
    try {
        plain.hash = slow_walk(hostile);
    } catch (const slow::Refusal& e) {
        plain.refused = e.kind;
        plain.message = e.what();
    }
    // The fast reader looks into the directory block that should name a page; the slow one reads them all
    // first. A block that no page led to must be refused by whoever reads it.
    const bool unread = fast.refused.empty() && plain.message.find("directory") != std::string::npos;
    if (unread) {
        ++tally["directory block not looked into"];
        EXPECT_TRUE(directory_is_refused(hostile)) << where << "\n  slow: " << plain.message;
    } else {
        EXPECT_EQ(fast.hash, plain.hash) << where;
        EXPECT_EQ(fast.refused.empty(), plain.refused.empty())
            << where << "\n  fast: " << fast.message << "\n  slow: " << plain.message;
    }
    ++tally[fast.refused.empty() ? "answered" : fast.refused];
}

enum class Region { header, anywhere };

void fuzz_behind_checksums(const MiniPlan& plan, int count, Region region, Random& random) {
    const Bytes whole = build_mini(plan).bytes;
    std::map<std::string, int> tally;
    for (int k = 0; k < count; ++k) {
        Bytes hostile = whole;
        const std::int64_t end =
            region == Region::header ? 160 + 4 * (plan.depth + 1) : static_cast<std::int64_t>(whole.size());
        std::string where;
        for (int n = static_cast<int>(random.integer(1, 3)); n > 0; --n) {
            const auto at =
                static_cast<std::size_t>(random.integer(region == Region::header ? 8 : 0, end - 1));
            // Small values, all ones and single bits reach more branches than uniform bytes.
            const std::array<int, 8> choice{0,
                                            1,
                                            2,
                                            0xFF,
                                            0x7F,
                                            0x80,
                                            static_cast<int>(hostile[at]) ^ (1 << random.integer(0, 7)),
                                            static_cast<int>(random.integer(0, 255))};
            hostile[at] = static_cast<std::byte>(choice[static_cast<std::size_t>(random.integer(0, 7))]);
            where += " " + std::to_string(at) + "=" + std::to_string(static_cast<int>(hostile[at]));
        }
        repair_checksums(hostile);
        expect_agreement(hostile, where, tally);
        if (::testing::Test::HasFailure()) return;
    }
    for (const auto& [what, times] : tally) std::cout << "  " << what << " " << times << '\n';
}

TEST(Hostile, HeadersWithRightChecksums) {
    Random random;
    SCOPED_TRACE(random.trace());
    fuzz_behind_checksums(small_plan(), 3000, Region::header, random);
    fuzz_behind_checksums(zero_plan(), 1000, Region::header, random);
}

TEST(Hostile, PagesDirectoriesAndRootsWithRightChecksums) {
    Random random;
    SCOPED_TRACE(random.trace());
    fuzz_behind_checksums(small_plan(), 3000, Region::anywhere, random);
    fuzz_behind_checksums(zero_plan(), 2000, Region::anywhere, random);
    fuzz_behind_checksums(split_plan(), 30, Region::anywhere, random);
}

}  // namespace
}  // namespace carat::test
