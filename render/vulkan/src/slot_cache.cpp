#include "slot_cache.hpp"

#include <algorithm>

namespace carat::vk {

// Same owner, so a mesh that was freed and another built at its address are told apart.
bool SlotCache::holds(const Entry& entry, const MeshPointer& mesh) {
    return !entry.mesh.owner_before(mesh) && !mesh.owner_before(entry.mesh);
}

bool SlotCache::resident(const MeshPointer& mesh) const {
    const auto found = by_half_.find(mesh->half);
    return found != by_half_.end() && holds(*found->second, mesh);
}

std::optional<SlotCache::Place> SlotCache::acquire(const MeshPointer& mesh) {
    const auto found = by_half_.find(mesh->half);
    if (found != by_half_.end()) {
        Entry& entry = *found->second;
        entries_.splice(entries_.begin(), entries_, found->second);
        const bool fresh = !holds(entry, mesh);
        if (fresh && entry.batch == batch_) return std::nullopt;  // two meshes of one half: one a batch
        entry.mesh = mesh;
        entry.batch = batch_;
        return Place{entry.slot, fresh};
    }
    const auto slot = free_slot();
    if (!slot) return std::nullopt;
    entries_.push_front({mesh->half, mesh, *slot, batch_});
    by_half_[mesh->half] = entries_.begin();
    return Place{*slot, true};
}

std::optional<std::uint32_t> SlotCache::free_slot() {
    if (entries_.size() < capacity_) return static_cast<std::uint32_t>(entries_.size());
    if (entries_.empty() || entries_.back().batch == batch_) return std::nullopt;
    const std::uint32_t slot = entries_.back().slot;
    by_half_.erase(entries_.back().half);
    entries_.pop_back();
    return slot;
}

void SlotCache::shrink(std::uint32_t capacity) {
    capacity_ = std::min(capacity_, capacity);
    for (auto entry = entries_.begin(); entry != entries_.end();) {
        const auto here = entry++;
        if (here->slot < capacity_) continue;
        by_half_.erase(here->half);
        entries_.erase(here);
    }
}

}  // namespace carat::vk
