// Least recently used first, and never a slot of the batch that is being put together.
#include <gtest/gtest.h>

#include "slot_cache.hpp"

namespace carat::vk {

namespace {

MeshPointer mesh(int number) {
    auto m = std::make_shared<PatchMesh>();
    m->half = {child(root_diamond(number / 8 % 6), number / 2 % 4), number % 2};
    return m;
}

TEST(SlotCache, HandsOutSlotsInOrder) {
    SlotCache cache(3);
    cache.begin_batch();
    for (std::uint32_t i = 0; i < 3; ++i) {
        const auto place = cache.acquire(mesh(static_cast<int>(i)));
        ASSERT_TRUE(place);
        EXPECT_EQ(place->slot, i);
        EXPECT_TRUE(place->fresh);
    }
    EXPECT_FALSE(cache.acquire(mesh(3))) << "all slots belong to this batch";
}

TEST(SlotCache, KeepsWhatItKnows) {
    SlotCache cache(2);
    const auto a = mesh(0);
    cache.begin_batch();
    EXPECT_FALSE(cache.resident(a));
    const auto first = cache.acquire(a);
    cache.begin_batch();
    EXPECT_TRUE(cache.resident(a));
    const auto second = cache.acquire(a);
    ASSERT_TRUE(first && second);
    EXPECT_EQ(first->slot, second->slot);
    EXPECT_FALSE(second->fresh);
}

TEST(SlotCache, EvictsTheLeastRecentlyUsed) {
    SlotCache cache(2);
    const auto a = mesh(0), b = mesh(1), c = mesh(2);
    cache.begin_batch();
    cache.acquire(a);
    cache.begin_batch();
    cache.acquire(b);
    cache.begin_batch();
    cache.acquire(a);
    cache.begin_batch();
    cache.acquire(c);
    EXPECT_TRUE(cache.resident(a));
    EXPECT_FALSE(cache.resident(b));
    EXPECT_TRUE(cache.resident(c));
}

TEST(SlotCache, ANewMeshOfAKnownHalfTakesItsSlot) {
    SlotCache cache(2);
    const auto a = mesh(0), again = mesh(0);
    cache.begin_batch();
    const auto old = cache.acquire(a);
    cache.begin_batch();
    EXPECT_FALSE(cache.resident(again));
    const auto place = cache.acquire(again);
    ASSERT_TRUE(old && place);
    EXPECT_EQ(place->slot, old->slot);
    EXPECT_TRUE(place->fresh);
    EXPECT_FALSE(cache.acquire(a)) << "two meshes of one half cannot share a batch";
}

TEST(SlotCache, ShrinksToTheSlotsThatAreLeft) {
    SlotCache cache(4);
    std::vector<MeshPointer> meshes;
    cache.begin_batch();
    for (int i = 0; i < 3; ++i) {
        meshes.push_back(mesh(i));
        cache.acquire(meshes.back());
    }
    cache.shrink(2);
    EXPECT_TRUE(cache.resident(meshes[0]));
    EXPECT_TRUE(cache.resident(meshes[1]));
    EXPECT_FALSE(cache.resident(meshes[2]));
    EXPECT_FALSE(cache.acquire(meshes[2])) << "the two slots belong to this batch";
    cache.begin_batch();
    EXPECT_EQ(cache.acquire(meshes[2])->slot, 0u);
}

// A mesh freed and another built at the same address are different meshes.
TEST(SlotCache, ForgetsFreedMeshes) {
    SlotCache cache(2);
    const Half half = mesh(0)->half;
    for (int i = 0; i < 100; ++i) {
        auto m = std::make_shared<PatchMesh>();
        m->half = half;
        cache.begin_batch();
        EXPECT_FALSE(cache.resident(m));
        EXPECT_TRUE(cache.acquire(m)->fresh);
    }
}

}  // namespace

}  // namespace carat::vk
