#include "carat/render/detail_surface.hpp"

#include <algorithm>
#include <list>
#include <mutex>
#include <unordered_map>

#include "carat/globe/bounds.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"

namespace carat {
namespace {

using Children = std::array<HalfHeights, 4>;  // [2h], [2h + 1] tile half h, as child_halves()

constexpr std::size_t kLeastEntries = 600;  // diamonds that one place at the deepest level needs, twice

}  // namespace

// What diamonds below the file refine to; least recently used go first.
struct DetailSurface::Cache {
    explicit Cache(std::size_t entries) : capacity(std::max(entries, kLeastEntries)) {}

    std::shared_ptr<const Children> find(DiamondId d) {
        const std::lock_guard lock(mutex);
        const auto it = by_id.find(d);
        if (it == by_id.end()) return nullptr;
        order.splice(order.begin(), order, it->second);
        return it->second->second;
    }
    void insert(DiamondId d, std::shared_ptr<const Children> children) {
        const std::lock_guard lock(mutex);
        if (by_id.contains(d)) return;
        order.emplace_front(d, std::move(children));
        by_id[d] = order.begin();
        if (order.size() <= capacity) return;
        by_id.erase(order.back().first);
        order.pop_back();
    }

    using Order = std::list<std::pair<DiamondId, std::shared_ptr<const Children>>>;
    const std::size_t capacity;
    std::mutex mutex;
    Order order;
    std::unordered_map<DiamondId, Order::iterator, DiamondIdHash> by_id;
};

DetailSurface::DetailSurface(std::shared_ptr<const Repository> repository,
                             std::shared_ptr<const Detail> detail, std::size_t cache_bytes)
    : repository_(std::move(repository)),
      detail_(std::move(detail)),
      surface_(repository_, cache_bytes / 2),
      body_(repository_->header().ellipsoid()),
      cache_(std::make_unique<Cache>(cache_bytes / 2 /
                                     (4 * 12 * half_vertex_count(repository_->header().cells())))) {}

DetailSurface::~DetailSurface() = default;

std::shared_ptr<const HalfHeights> DetailSurface::heights(const Half& half) const {
    const auto of_file = [&](HalfHeights out) {
        if (!repository_->refined(half.diamond)) detail_->begin(*repository_, half, out);
        return std::make_shared<const HalfHeights>(std::move(out));
    };
    const int level = half.diamond.level();
    if (level == 0)
        return of_file(
            std::move(split(repository_->root(half.diamond.face()))[static_cast<std::size_t>(half.side)]));
    const DiamondId up = *parent(half.diamond, half.side);
    if (repository_->refined(up)) return of_file(gather_child(*surface_.refined_heights(up), up, half));

    std::shared_ptr<const Children> children = cache_->find(up);
    if (!children) {
        const auto half0 = heights({up, 0}), half1 = heights({up, 1});
        VirtualHeights refined;
        detail_->refine(up, level - 1, *half0, *half1, refined);
        auto made = std::make_shared<Children>();
        for (const int side : {0, 1})
            for (const std::size_t leg : {0u, 1u})
                (*made)[2 * static_cast<std::size_t>(side) + leg] =
                    gather_child(refined, up, child_halves({up, side})[leg]);
        cache_->insert(up, made);
        children = std::move(made);
    }
    for (const int side : {0, 1})
        for (const std::size_t leg : {0u, 1u})
            if (child_halves({up, side})[leg] == half)
                return {children, &(*children)[2 * static_cast<std::size_t>(side) + leg]};
    return nullptr;
}

DetailSurface::Sample DetailSurface::sample(const RealLattice& place) const {
    const Surface::Sample measured = surface_.sample(place);
    Half half = measured.half;
    int level = half.diamond.level();
    if (measured.at_lattice || level >= detail_->end_level())
        return {measured.height, measured.spacing, measured.at_lattice, false};
    for (; level < detail_->end_level(); ++level) {
        const Location at = locate_in(place, half);
        half = child_halves(half)[at.s + at.t <= 1 ? 0 : 1];
    }
    const int cells = repository_->header().cells();
    const Location at = locate_in(place, half);
    const double s = half.side == 0 ? at.s : std::min(at.s, at.t);
    const double t = half.side == 0 ? std::min(at.s, at.t) : at.t;
    const TriangleWeights w =
        triangle_weights(std::clamp(s, 0.0, 1.0) * cells, std::clamp(t, 0.0, 1.0) * cells, cells);
    const auto h = heights(half);
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k)
        if (w.weight[k] != 0)
            height +=
                w.weight[k] * static_cast<double>(h->at(half_vertex_index(w.vertex[k][0], w.vertex[k][1])));
    return {height * kHeightFraction * repository_->header().quantum,
            sample_spacing(body_, half.diamond, cells), false, true};
}

}  // namespace carat
