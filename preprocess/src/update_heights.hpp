// Reconstructed heights of a file before and after an update, decoded when they are asked for.
#pragma once

#include <functional>
#include <list>
#include <memory>
#include <mutex>
#include <unordered_map>

#include "build_passes.hpp"

namespace carat {

using RefinedPtr = std::shared_ptr<const RefinedHeights>;

// A bounded map of refined heights; least recently used goes first. Thread-safe.
class RefinedCache {
  public:
    explicit RefinedCache(std::size_t bytes) : capacity_(bytes) {}
    RefinedPtr find(DiamondId d);
    void insert(DiamondId d, RefinedPtr heights);

  private:
    using Order = std::list<std::pair<DiamondId, RefinedPtr>>;
    std::size_t capacity_, bytes_ = 0;
    std::mutex mutex_;
    Order order_;
    std::unordered_map<DiamondId, Order::iterator, DiamondIdHash> map_;
};

// Heights of all refined diamonds of one state of a file. Thread-safe.
class DecodedHeights {
  public:
    // Decodes V and C of a diamond from its P; or gives them from elsewhere, ignoring p.
    using Refine = std::function<void(DiamondId d, const std::vector<std::int32_t>& p, RefinedHeights& out)>;

    // elsewhere: heights that are known without decoding, null if they are not.
    DecodedHeights(const FaceHeights& roots, int n, std::size_t cache_bytes, Refine refine,
                   std::function<RefinedPtr(DiamondId)> elsewhere = {});

    // Of a refined diamond.
    RefinedPtr refined(DiamondId d);
    // P of a diamond whose parents are refined, N x N.
    void vertices(DiamondId d, std::vector<std::int32_t>& p);
    // One half of it.
    void vertices(const Half& half, std::vector<std::int32_t>& p);
    // What refined() would decode.
    void remember(DiamondId d, RefinedPtr heights) { cache_.insert(d, std::move(heights)); }

  private:
    const FaceHeights& roots_;
    int n_;
    RefinedCache cache_;
    Refine refine_;
    std::function<RefinedPtr(DiamondId)> elsewhere_;
};

}  // namespace carat
