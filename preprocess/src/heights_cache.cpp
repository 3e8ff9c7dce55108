#include "heights_cache.hpp"

#include "build_levels.hpp"
#include "packed.hpp"

namespace carat {

void HeightsCache::put(int level, std::size_t position, CodedHeightsPtr heights) {
    const std::uint64_t key = key_of(level, position);
    Shard& shard = shard_of(key);
    const std::lock_guard lock(shard.mutex);
    const auto [it, is_new] = shard.entries.try_emplace(key);
    if (!is_new) return;
    shard.bytes += heights->bytes();
    shard.order.push_front(key);
    it->second = {std::move(heights), shard.order.begin()};
    while (shard.bytes > capacity_ && shard.order.size() > 1) {
        const auto oldest = shard.entries.find(shard.order.back());
        shard.bytes -= oldest->second.heights->bytes();
        shard.entries.erase(oldest);
        shard.order.pop_back();
    }
}

CodedHeightsPtr HeightsCache::get(int level, std::size_t position) {
    const std::uint64_t key = key_of(level, position);
    Shard& shard = shard_of(key);
    {
        const std::lock_guard lock(shard.mutex);
        if (const auto it = shard.entries.find(key); it != shard.entries.end()) {
            shard.order.splice(shard.order.begin(), shard.order, it->second.place);
            return it->second.heights;
        }
    }
    thread_local std::vector<std::byte> record;
    store_.read({StepKind::heights, level, position / kStepDiamonds}, position % kStepDiamonds, record);
    CodedHeightsPtr heights = of_record(record);
    put(level, position, heights);
    return heights;
}

std::vector<std::byte> HeightsCache::to_record(const CodedHeights& heights) const {
    std::vector<std::byte> out;
    const auto n = static_cast<std::size_t>(n_);
    if (keeps_p_) pack(heights.p, n, out);
    pack(heights.refined.v, n, out);
    pack(heights.refined.c, n - 1, out);
    return out;
}

CodedHeightsPtr HeightsCache::of_record(const std::vector<std::byte>& record) const {
    auto out = std::make_shared<CodedHeights>();
    const auto n = static_cast<std::size_t>(n_), vertices = n * n, cells = (n - 1) * (n - 1);
    out->refined.n = n_;
    out->refined.v.resize(vertices);
    out->refined.c.resize(cells);
    std::span<const std::byte> in(record);
    if (keeps_p_) {
        out->p.resize(vertices);
        in = unpack(in, n, out->p);
    }
    in = unpack(in, n, out->refined.v);
    unpack(in, n - 1, out->refined.c);
    return out;
}

}  // namespace carat
