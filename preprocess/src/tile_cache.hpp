// Decoded blocks of samples, shared by all threads, least recently used dropped first.
#pragma once

#include <array>
#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

namespace carat {

// A rectangle of a grid. Samples are row-major in the grid's type.
struct Tile {
    std::int64_t x = 0, y = 0;  // of its first sample in the grid
    int width = 0, height = 0;
    std::vector<std::byte> samples;   // empty: all holes
    std::vector<std::uint8_t> valid;  // 1 sample, 0 hole; empty: no holes

    std::size_t bytes() const { return sizeof(Tile) + samples.size() + valid.size(); }
};
using TilePtr = std::shared_ptr<const Tile>;

// Thread-safe. A tile in use stays alive with whoever uses it.
class TileCache {
  public:
    explicit TileCache(std::size_t capacity_bytes) : capacity_(capacity_bytes / kShards) {}

    using Load = std::function<TilePtr()>;
    // The tile of a key; loaded once, without holding the cache, if it is not there. Load's exceptions pass
    // through.
    TilePtr get(std::uint64_t key, const Load& load);

  private:
    struct Entry {
        TilePtr tile;  // null while it is being loaded
        std::list<std::uint64_t>::iterator place;
    };
    struct Shard {
        std::mutex mutex;
        std::condition_variable loaded;
        std::unordered_map<std::uint64_t, Entry> entries;
        std::list<std::uint64_t> order;  // latest first; only loaded ones
        std::size_t bytes = 0;
    };
    void trim(Shard& shard) const;

    static constexpr std::size_t kShards = 16;
    std::array<Shard, kShards> shards_;
    std::size_t capacity_;
};

}  // namespace carat
