#include "update_heights.hpp"

#include <algorithm>

namespace carat {
namespace {

std::size_t bytes_of(const RefinedHeights& h) {
    constexpr std::size_t kNodes = 200;
    return kNodes + 4 * (h.v.capacity() + h.c.capacity());
}

}  // namespace

RefinedPtr RefinedCache::find(DiamondId d) {
    const std::lock_guard lock(mutex_);
    const auto it = map_.find(d);
    if (it == map_.end()) return nullptr;
    order_.splice(order_.begin(), order_, it->second);
    return it->second->second;
}

void RefinedCache::insert(DiamondId d, RefinedPtr heights) {
    const std::lock_guard lock(mutex_);
    if (map_.contains(d)) return;
    bytes_ += bytes_of(*heights);
    order_.emplace_front(d, std::move(heights));
    map_[d] = order_.begin();
    while (bytes_ > capacity_ && order_.size() > 1) {
        bytes_ -= bytes_of(*order_.back().second);
        map_.erase(order_.back().first);
        order_.pop_back();
    }
}

DecodedHeights::DecodedHeights(const FaceHeights& roots, int n, std::size_t cache_bytes, Refine refine,
                               std::function<RefinedPtr(DiamondId)> elsewhere)
    : roots_(roots),
      n_(n),
      cache_(cache_bytes),
      refine_(std::move(refine)),
      elsewhere_(std::move(elsewhere)) {}

RefinedPtr DecodedHeights::refined(DiamondId d) {
    if (elsewhere_)
        if (RefinedPtr known = elsewhere_(d)) return known;
    if (RefinedPtr found = cache_.find(d)) return found;
    std::vector<std::int32_t> p;
    vertices(d, p);
    auto out = std::make_shared<RefinedHeights>();
    refine_(d, p, *out);
    cache_.insert(d, out);
    return out;
}

void DecodedHeights::vertices(DiamondId d, std::vector<std::int32_t>& p) {
    p.resize(static_cast<std::size_t>(n_ * n_));
    for (const int side : {0, 1}) vertices(Half{d, side}, p);
}

void DecodedHeights::vertices(const Half& half, std::vector<std::int32_t>& p) {
    p.resize(static_cast<std::size_t>(n_ * n_));
    if (half.diamond.level() == 0) {
        p = roots_[static_cast<std::size_t>(half.diamond.face())];
        return;
    }
    const DiamondId up = *parent(half.diamond, half.side);
    gather_half(*refined(up), up, half, p.data());
}

}  // namespace carat
