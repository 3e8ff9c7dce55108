// Halves in sight whose meshes are not there: a change of the view brings them. A mesh that does not come in
// time is built in the frame, or gives way to a coarser one, whichever takes less time.
#include <algorithm>

#include "refiner_state.hpp"
#include "stopwatch.hpp"

namespace carat {
namespace {

constexpr int kManyRefined = 256;  // to be counted no further

// How many diamonds from n downwards are refined; those with two parents may count twice.
int count_refined(const LiveNode& n, int most) {
    int count = 1;
    for (const LiveHalf* child : n.child_halves)
        if (child->node->refined && count < most) count += count_refined(*child->node, most - count);
    return count;
}

}  // namespace

// The diamond around it is coarsened with all below; what that uncovers may have to be built.
double Refiner::State::cover_ms(const Half& half) const {
    const LiveNode& up = *graph_.find(*parent(half.diamond, half.side));
    double ms = coarsen_ms_ * count_refined(up, kManyRefined);
    for (const LiveHalf& uncovered : up.halves)
        if (!uncovered.data.mesh) ms += build_ms_;
    return ms;
}

void Refiner::State::add_missing(const LiveHalf& half) {
    const double ms = to_the_end_ ? 0 : cover_ms(half.half());
    if (missing_.emplace(half.half(), ms).second) missing_ms_ += std::min(ms, build_ms_);
}

void Refiner::State::remove_missing(const Half& half) {
    const auto it = missing_.find(half);
    if (it == missing_.end()) return;
    missing_ms_ -= std::min(it->second, build_ms_);
    missing_.erase(it);
    if (missing_.empty()) missing_ms_ = 0;
}

// To the end, halves that will be refined need none.
void Refiner::State::request_missing_meshes() {
    for (const auto& [half, ms] : missing_) {
        const LiveNode& n = *graph_.find(half.diamond);
        if (direct_ && !full_ && n.needed == frame_) continue;
        request_mesh(n.halves[static_cast<std::size_t>(half.side)].data, kUrgent);
    }
}

// Colours may have to be read first, which takes too long.
bool Refiner::State::build_here(LiveHalf& half, std::size_t spares_left) {
    if (to_the_end_ || maker_.coloured() || spares_.size() <= spares_left) return false;
    std::shared_ptr<PatchMesh> mesh = std::move(spares_.back());
    spares_.pop_back();
    ++spares_built_;
    WorkTimes times;
    maker_.build(half.half(), *half.data.heights, *mesh, times);
    build_ms_ = eased(build_ms_, times.build_ms);
    counters_.build_ms += times.build_ms;
    counters_.built += times.built;
    take_mesh(mesh);
    return true;
}

// Before anything is refined: what would take long at the frame's end.
void Refiner::State::build_what_covering_costs_more() {
    if (to_the_end_ || missing_.empty()) return;
    List<LiveHalf*> costly(&heap_);
    for (const auto& [half, ms] : missing_)
        if (build_is_cheaper(ms))
            costly.push_back(&graph_.find(half.diamond)->halves[static_cast<std::size_t>(half.side)]);
    std::sort(costly.begin(), costly.end(), [this](const LiveHalf* l, const LiveHalf* r) {
        const double left = missing_.at(l->half()), right = missing_.at(r->half());
        return left != right ? left > right : l->half() < r->half();
    });
    for (LiveHalf* half : costly)
        if (time_is_up() || !build_here(*half, 0)) return;
}

// Workers may not get to them in time.
bool Refiner::State::build_missing_meshes() {
    bool any = false;
    while (!missing_.empty() && !time_is_up()) {
        const Half half = missing_.begin()->first;
        if (!build_here(graph_.find(half.diamond)->halves[static_cast<std::size_t>(half.side)], 0)) break;
        collect();
        any = true;
    }
    return any;
}

// What has not come in time gives way to the coarser half around it, unless it is sooner built. The faces'
// meshes are always there.
void Refiner::State::cover_missing_meshes() {
    while (!missing_.empty()) {
        const Half half = missing_.begin()->first;
        LiveHalf& live = graph_.find(half.diamond)->halves[static_cast<std::size_t>(half.side)];
        if (!to_the_end_ && build_is_cheaper(cover_ms(half)) && build_here(live, 0)) continue;
        const std::uint64_t before = counters_.coarsened;
        double milliseconds = 0;
        {
            const Stopwatch watch(milliseconds);
            coarsen_with_children(*graph_.find(*parent(half.diamond, half.side)));
        }
        coarsen_ms_ = eased(coarsen_ms_, milliseconds / static_cast<double>(counters_.coarsened - before));
        ++counters_.forced_coarse;
    }
}

}  // namespace carat
