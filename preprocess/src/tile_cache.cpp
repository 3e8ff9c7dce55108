#include "tile_cache.hpp"

namespace carat {

void TileCache::trim(Shard& shard) const {
    while (shard.bytes > capacity_ && shard.order.size() > 1) {
        const auto oldest = shard.entries.find(shard.order.back());
        shard.bytes -= oldest->second.tile->bytes();
        shard.entries.erase(oldest);
        shard.order.pop_back();
    }
}

TilePtr TileCache::get(std::uint64_t key, const Load& load) {
    Shard& shard = shards_[(key * 0x9E3779B97F4A7C15u) >> 60];
    std::unique_lock lock(shard.mutex);
    for (;;) {
        const auto [it, is_new] = shard.entries.try_emplace(key);
        if (is_new) break;
        if (it->second.tile) {
            shard.order.splice(shard.order.begin(), shard.order, it->second.place);
            return it->second.tile;
        }
        shard.loaded.wait(lock);
    }
    lock.unlock();
    TilePtr tile;
    try {
        tile = load();
    } catch (...) {
        lock.lock();
        shard.entries.erase(key);
        shard.loaded.notify_all();
        throw;
    }
    lock.lock();
    Entry& entry = shard.entries.at(key);
    entry.tile = tile;
    shard.order.push_front(key);
    entry.place = shard.order.begin();
    shard.bytes += tile->bytes();
    trim(shard);
    shard.loaded.notify_all();
    return tile;
}

}  // namespace carat
