// Refinements that are not in the cut: made ahead, late, or coarsened away. Least recently used first out.
#pragma once

#include <list>
#include <memory>
#include <unordered_map>

#include "frame_heap.hpp"
#include "refinement.hpp"

namespace carat {

class RefinementCache {
  public:
    explicit RefinementCache(FrameHeap& heap) : entries_(&heap), by_id_(&heap) {}

    bool contains(DiamondId id) const { return by_id_.contains(id); }
    // Null if there is none; else it is now the most recently used.
    Refinement* find(DiamondId id);
    // Returns the one of the same diamond that it replaces.
    std::unique_ptr<Refinement> insert(std::unique_ptr<Refinement> refinement);
    std::unique_ptr<Refinement> extract(DiamondId id);

    bool empty() const { return entries_.empty(); }
    std::uint64_t bytes() const { return bytes_; }
    // To be called when a mesh has been added to a refinement in here.
    void grew(std::uint64_t bytes) { bytes_ += bytes; }
    // Of the least recently used. Precondition: there is one.
    DiamondId oldest() const { return entries_.back()->id; }
    // Takes out the least recently used; null if there is none.
    std::unique_ptr<Refinement> extract_oldest();

  private:
    using Entries = std::pmr::list<std::unique_ptr<Refinement>>;  // most recently used first
    Entries entries_;
    std::pmr::unordered_map<DiamondId, Entries::iterator, DiamondIdHash> by_id_;
    std::uint64_t bytes_ = 0;
};

std::uint64_t bytes_of(const Refinement& refinement);

}  // namespace carat
