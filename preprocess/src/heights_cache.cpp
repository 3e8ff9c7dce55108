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
    if (keeps_p_) pack(heights.p, out);
    pack(heights.refined.v, out);
    pack(heights.refined.c, out);
    return out;
}

CodedHeightsPtr HeightsCache::of_record(const std::vector<std::byte>& record) const {
    auto out = std::make_shared<CodedHeights>();
    const auto vertices = static_cast<std::size_t>(n_ * n_),
               cells = static_cast<std::size_t>((n_ - 1) * (n_ - 1));
    out->refined.n = n_;
    out->refined.v.resize(vertices);
    out->refined.c.resize(cells);
    std::span<const std::byte> in(record);
    if (keeps_p_) {
        out->p.resize(vertices);
        in = unpack(in, out->p);
    }
    in = unpack(in, out->refined.v);
    unpack(in, out->refined.c);
    return out;
}

}  // namespace carat
