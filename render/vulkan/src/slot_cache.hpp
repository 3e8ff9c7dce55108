// Which patch lives in which slot; least recently used first out. Knows no GPU.
#pragma once

#include <cstdint>
#include <list>
#include <memory>
#include <optional>
#include <unordered_map>

#include "carat/render/patch_mesh.hpp"

namespace carat::vk {

using MeshPointer = std::shared_ptr<const PatchMesh>;

class SlotCache {
  public:
    explicit SlotCache(std::uint32_t capacity) : capacity_(capacity) {}

    // Slots acquired from here on stay until the next call.
    void begin_batch() { ++batch_; }

    // True if this very mesh object is in a slot.
    bool resident(const MeshPointer& mesh) const;

    struct Place {
        std::uint32_t slot = 0;
        bool fresh = false;  // the mesh is not in the slot yet: the caller must upload it
    };
    // A slot for the mesh, kept until the next batch; nothing if all slots are taken in this batch. Slots are
    // handed out in ascending order until all have been used once.
    std::optional<Place> acquire(const MeshPointer& mesh);

    // Gives up the slots from `capacity` on and what is in them.
    void shrink(std::uint32_t capacity);

  private:
    struct Entry {
        Half half;
        std::weak_ptr<const PatchMesh> mesh;
        std::uint32_t slot;
        std::uint64_t batch;
    };
    using Entries = std::list<Entry>;

    static bool holds(const Entry& entry, const MeshPointer& mesh);
    std::optional<std::uint32_t> free_slot();

    std::uint32_t capacity_;
    std::uint64_t batch_ = 0;
    Entries entries_;  // most recently used first
    std::unordered_map<Half, Entries::iterator, HalfHash> by_half_;
};

}  // namespace carat::vk
