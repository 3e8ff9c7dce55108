#include "refinement_cache.hpp"

namespace carat {

std::uint64_t bytes_of(const Refinement& refinement) {
    std::uint64_t bytes = 0;
    for (const ChildHalf& child : refinement.children) bytes += bytes_of(child);
    return bytes;
}

Refinement* RefinementCache::find(DiamondId id) {
    const auto it = by_id_.find(id);
    if (it == by_id_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, it->second);
    return it->second->get();
}

std::unique_ptr<Refinement> RefinementCache::insert(std::unique_ptr<Refinement> refinement) {
    const DiamondId id = refinement->id;
    std::unique_ptr<Refinement> before = extract(id);
    bytes_ += bytes_of(*refinement);
    entries_.push_front(std::move(refinement));
    by_id_.emplace(id, entries_.begin());
    return before;
}

std::unique_ptr<Refinement> RefinementCache::extract(DiamondId id) {
    const auto it = by_id_.find(id);
    if (it == by_id_.end()) return nullptr;
    std::unique_ptr<Refinement> out = std::move(*it->second);
    bytes_ -= bytes_of(*out);
    entries_.erase(it->second);
    by_id_.erase(it);
    return out;
}

std::unique_ptr<Refinement> RefinementCache::extract_oldest() {
    return entries_.empty() ? nullptr : extract(entries_.back()->id);
}

}  // namespace carat
