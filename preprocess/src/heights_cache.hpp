// Reconstructed heights of refined diamonds, in memory while there is room, from the temporary files
// otherwise.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "carat/codec/heights.hpp"
#include "step_store.hpp"

namespace carat {

// What the levels below need of a coded diamond.
struct CodedHeights {
    std::vector<std::int32_t> p;  // n * n; empty where V = P (mode 0)
    RefinedHeights refined;

    const std::vector<std::int32_t>& vertices() const { return p.empty() ? refined.v : p; }
    std::size_t bytes() const {
        return sizeof(CodedHeights) + 4 * (p.capacity() + refined.v.capacity() + refined.c.capacity());
    }
};
using CodedHeightsPtr = std::shared_ptr<const CodedHeights>;

// Thread-safe.
class HeightsCache {
  public:
    // keeps_p: records hold P besides V and C.
    HeightsCache(StepStore& store, int n, bool keeps_p, std::size_t capacity_bytes)
        : store_(store), n_(n), keeps_p_(keeps_p), capacity_(capacity_bytes / kShards) {}

    void put(int level, std::size_t position, CodedHeightsPtr heights);
    // Of a diamond whose step is in the store or the cache. Throws Error(io).
    CodedHeightsPtr get(int level, std::size_t position);
    std::vector<std::byte> to_record(const CodedHeights& heights) const;

  private:
    struct Entry {
        CodedHeightsPtr heights;
        std::list<std::uint64_t>::iterator place;
    };
    struct Shard {
        std::mutex mutex;
        std::unordered_map<std::uint64_t, Entry> entries;
        std::list<std::uint64_t> order;  // latest first
        std::size_t bytes = 0;
    };
    static constexpr std::size_t kShards = 16;

    static std::uint64_t key_of(int level, std::size_t position) {
        return (static_cast<std::uint64_t>(level) << 56) | position;
    }
    Shard& shard_of(std::uint64_t key) { return shards_[(key * 0x9E3779B97F4A7C15u) >> 60]; }
    CodedHeightsPtr of_record(const std::vector<std::byte>& record) const;

    StepStore& store_;
    int n_;
    bool keeps_p_;
    std::size_t capacity_;
    std::array<Shard, kShards> shards_;
};

}  // namespace carat
