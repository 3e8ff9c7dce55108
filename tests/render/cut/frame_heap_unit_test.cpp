// The frame's memory: kept, aligned, given back by anybody.
#include <gtest/gtest.h>

#include <cstring>
#include <set>
#include <thread>
#include <vector>

#include "frame_heap.hpp"

namespace carat {
namespace {

TEST(FrameHeap, BlocksAreAlignedApartAndUsedAgain) {
    FrameHeap heap;
    std::set<void*> blocks;
    for (const std::size_t bytes : {1u, 32u, 33u, 64u, 100u, 5000u, 1u << 20}) {
        void* const block = heap.allocate(bytes, bytes > 32 ? 64 : 16);
        EXPECT_EQ(reinterpret_cast<std::uintptr_t>(block) % (bytes > 32 ? 64 : 16), 0u);
        std::memset(block, 0x5a, bytes);
        EXPECT_TRUE(blocks.insert(block).second);
        heap.deallocate(block, bytes, bytes > 32 ? 64 : 16);
        void* const again = heap.allocate(bytes, bytes > 32 ? 64 : 16);
        EXPECT_EQ(again, block);
    }
}

TEST(FrameHeap, GrowsBeyondAChunkAndBeyondItsGreatestBlock) {
    FrameHeap heap;
    std::vector<std::pair<void*, std::size_t>> all;
    for (int k = 0; k < 40; ++k) {
        const std::size_t bytes = k % 10 == 0 ? FrameHeap::kGreatest + 1 : std::size_t{1} << 19;
        all.emplace_back(heap.allocate(bytes), bytes);
        std::memset(all.back().first, k, bytes);
    }
    for (std::size_t k = 0; k < all.size(); ++k)
        for (const std::size_t at : {std::size_t{0}, all[k].second - 1})
            EXPECT_EQ(static_cast<unsigned char*>(all[k].first)[at], k);
    for (const auto& [block, bytes] : all) heap.deallocate(block, bytes);
}

// Other threads give back while the owner goes on taking: for the sanitizers too.
TEST(FrameHeap, AnyThreadMayGiveBack) {
    FrameHeap heap;
    std::set<void*> seen;
    for (int round = 0; round < 200; ++round) {
        std::vector<void*> blocks;
        for (int k = 0; k < 50; ++k) {
            blocks.push_back(heap.allocate(100));
            std::memset(blocks.back(), round, 100);
            seen.insert(blocks.back());
        }
        std::thread([&heap, blocks] {
            for (void* b : blocks) heap.deallocate(b, 100);
        }).join();
        heap.deallocate(heap.allocate(100), 100);
    }
    EXPECT_LE(seen.size(), 60u) << "what other threads give back is used again";
}

}  // namespace
}  // namespace carat
