#include "carat/codec/surface.hpp"

#include <algorithm>
#include <cmath>
#include <list>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"

namespace carat {
namespace {

// A bounded map from diamonds to shared values; least recently used goes first. Thread-safe.
template <class Value>
class LruCache {
  public:
    explicit LruCache(std::size_t entries) : capacity_(entries) {}

    std::shared_ptr<const Value> find(DiamondId d) {
        const std::lock_guard lock(mutex_);
        const auto it = map_.find(d);
        if (it == map_.end()) return nullptr;
        order_.splice(order_.begin(), order_, it->second);
        return it->second->second;
    }
    std::shared_ptr<const Value> insert(DiamondId d, std::shared_ptr<const Value> value) {
        const std::lock_guard lock(mutex_);
        if (const auto it = map_.find(d); it != map_.end()) return it->second->second;
        order_.emplace_front(d, std::move(value));
        map_[d] = order_.begin();
        if (order_.size() > capacity_) {
            map_.erase(order_.back().first);
            order_.pop_back();
        }
        return order_.front().second;
    }

  private:
    using Order = std::list<std::pair<DiamondId, std::shared_ptr<const Value>>>;
    std::size_t capacity_;
    std::mutex mutex_;
    Order order_;
    std::unordered_map<DiamondId, typename Order::iterator, DiamondIdHash> map_;
};

std::size_t entries_for(std::size_t bytes, int n) {
    constexpr std::size_t kNodes = 400;  // of lists, maps and vectors, for an entry of each cache
    const auto each = static_cast<std::size_t>(n * n + 2 * (n * n) / 2) * sizeof(std::int32_t) * 2 + kNodes;
    return std::max<std::size_t>(64, bytes / each);
}

}  // namespace

struct Surface::Cache {
    explicit Cache(std::size_t entries) : heights(entries), refined(entries) {}
    LruCache<Heights> heights;
    LruCache<RefinedHeights> refined;
};

Surface::Surface(std::shared_ptr<const Repository> repository, std::size_t cache_bytes)
    : repository_(std::move(repository)),
      body_(repository_->header().ellipsoid()),
      cache_(std::make_unique<Cache>(entries_for(cache_bytes, repository_->header().n()))) {}

Surface::~Surface() = default;

const Repository& Surface::repository() const { return *repository_; }

std::shared_ptr<const Heights> Surface::heights(DiamondId d) const {
    if (auto found = cache_->heights.find(d)) return found;
    if (d.level() == 0)
        return cache_->heights.insert(d, std::make_shared<Heights>(repository_->root(d.face())));
    auto out = std::make_shared<Heights>();
    out->n = repository_->header().n();
    out->values.resize(static_cast<std::size_t>(out->n * out->n));
    for (int side = 0; side < 2; ++side) {
        const DiamondId up = *parent(d, side);
        if (!repository_->refined(up)) continue;
        gather_half(*refined_heights(up), up, {d, side}, out->values.data());
        out->has_half[static_cast<std::size_t>(side)] = true;
    }
    if (!out->has_half[0] && !out->has_half[1])
        throw Error(ErrorCode::usage, "diamond " + to_string(d) + " is not in the file");
    return cache_->heights.insert(d, std::move(out));
}

std::shared_ptr<const RefinedHeights> Surface::refined_heights(DiamondId d) const {
    if (auto found = cache_->refined.find(d)) return found;
    const auto p = heights(d);
    if (!p->has_half[0] || !p->has_half[1])
        throw Error(ErrorCode::corrupt, "diamond " + to_string(d) + " is refined without both its parents");
    auto out = std::make_shared<RefinedHeights>();
    repository_->refine(d, *p, *out);
    return cache_->refined.insert(d, std::move(out));
}

Surface::Sample Surface::sample(const RealLattice& place) const {
    const RepositoryHeader& header = repository_->header();
    Sample s;
    s.half = leaf_half(*repository_, place);
    const Location at = locate_in(place, s.half);
    // Rounding must not push the place over the longest edge: the other half may be absent.
    const double s_in = s.half.side == 0 ? at.s : std::min(at.s, at.t);
    const double t_in = s.half.side == 0 ? std::min(at.s, at.t) : at.t;
    const TriangleWeights w = triangle_weights(s_in * header.cells(), t_in * header.cells(), header.cells());
    const auto p = heights(s.half.diamond);
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k) {
        if (w.weight[k] == 0) continue;  // a corner outside the half
        height += w.weight[k] * p->at(w.vertex[k][0], w.vertex[k][1]);
        s.at_lattice |= w.weight[k] == 1;
    }
    s.height = height * header.quantum;
    s.spacing = sample_spacing(body_, s.half.diamond, header.cells());
    return s;
}

Half leaf_half(const Repository& repository, const RealLattice& place) {
    Half half = locate(place, 0).half;
    while (repository.refined(half.diamond)) {
        // The children part at the line from x to the centre, s + t = 1. Descending through child halves, and
        // not by locating anew, keeps to halves that exist when the place lies on an edge.
        const Location at = locate_in(place, half);
        half = child_halves(half)[at.s + at.t <= 1 ? 0 : 1];
    }
    return half;
}

}  // namespace carat
