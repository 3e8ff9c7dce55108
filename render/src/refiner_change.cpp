#include <algorithm>
#include <limits>
#include <utility>

#include "refiner_state.hpp"
#include "stopwatch.hpp"

namespace carat {

void Refiner::State::refine_candidates() {
    // A frame makes some progress, however short.
    while (!candidates_.empty() && (!time_is_up() || counters_.installed == 0)) {
        const Candidate c = candidates_.top();
        LiveNode* const n = graph_.find(c.id);
        const bool moot =
            n == nullptr || n->refined || !n->complete() || n->needed != frame_ || c.priority != n->priority;
        candidates_.pop();
        full_ = !moot && refine(*n) == Step::full;
        if (full_) return candidates_.push(c);
    }
}

Refiner::State::Step Refiner::State::refine(LiveNode& n) {
    const Refinement* const refinement = cache_.find(n.id);
    if (refinement == nullptr) {
        request(n);
        return Step::waits;
    }
    if (!direct_ && !meshes_ready(n, *refinement)) return Step::waits;
    if (!within_uploads(n, *refinement)) return Step::full;
    while (!within_budgets(n, *refinement))
        if (!make_room(n.priority)) return Step::full;
    install(n);
    return Step::done;
}

// All child halves in sight have meshes, or these are asked for.
bool Refiner::State::meshes_ready(const LiveNode& n, const Refinement& refinement) {
    bool ready = true;
    for (const ChildHalf& child : refinement.children) {
        if (child.mesh || !shown(judge(child, n.level + 1))) continue;
        request_mesh(child, n.priority);
        ready = false;
    }
    return ready;
}

// One diamond a frame always is.
bool Refiner::State::within_uploads(const LiveNode& n, const Refinement& refinement) const {
    std::uint64_t bytes = 0;
    for (const ChildHalf& child : refinement.children)
        if (!child.published && shown(judge(child, n.level + 1))) bytes += maker_.mesh_bytes();
    return bytes <= upload_left_ || counters_.installed == 0;
}

bool Refiner::State::within_budgets(const LiveNode& n, const Refinement& refinement) const {
    std::uint64_t patches = drawn_;
    for (const LiveHalf& half : n.halves) patches -= shown(half) ? 1 : 0;
    for (const ChildHalf& child : refinement.children) patches += shown(judge(child, n.level + 1)) ? 1 : 0;
    const std::uint64_t cells = static_cast<std::uint64_t>(cells_);
    return patches * cells * cells <= options_.triangles &&
           live_bytes_ + bytes_of(refinement) <= options_.bytes;
}

// Coarsens what matters least, if it matters less than this.
bool Refiner::State::make_room(double priority) {
    if (live_bytes_ > options_.bytes / 2) drop_inner_meshes();
    LiveNode* least = nullptr;
    double least_priority = priority;
    for (const auto& n : graph_.nodes()) {
        if (!n->refined || LiveGraph::has_refined_child(*n)) continue;
        const double p = n->needed == frame_ ? n->priority : -1;
        if (p < least_priority || (p == least_priority && least != nullptr && least->id < n->id)) {
            least = n.get();
            least_priority = p;
        }
    }
    return least != nullptr && try_coarsen(*least, priority);
}

void Refiner::State::install(LiveNode& n) {
    for (LiveHalf& half : n.halves) leave_frontier(half);
    std::unique_ptr<Refinement> refinement = cache_.extract(n.id);
    live_bytes_ += bytes_of(*refinement);
    graph_.install(n, std::move(refinement));
    ++counters_.installed;
    open_.assign(n.child_halves.begin(), n.child_halves.end());
    work_through();
    for (LiveHalf* half : n.child_halves) {
        enter_frontier(*half);
        if (shown(*half) && !half->data.published)
            upload_left_ -= std::min<std::uint64_t>(upload_left_, maker_.mesh_bytes());
        // Needed before it was complete.
        const LiveNode& child = *half->node;
        if (child.needed == frame_ && child.complete())
            candidates_.push({child.priority, child.level, child.id});
    }
}

void Refiner::State::coarsen(LiveNode& n) {
    for (LiveHalf* half : n.child_halves) leave_frontier(*half);
    std::unique_ptr<Refinement> refinement = graph_.coarsen(n);
    live_bytes_ -= bytes_of(*refinement);
    discard(cache_.insert(std::move(refinement)));
    ++counters_.coarsened;
    for (LiveHalf& half : n.halves) {
        if (half.judged != frame_) judge(half);
        enter_frontier(half);
    }
}

// Coarsens if the meshes that this uncovers are there; asks for them otherwise.
bool Refiner::State::try_coarsen(LiveNode& n, double priority) {
    bool ready = true;
    for (LiveHalf& half : n.halves) {
        if (half.judged != frame_) judge(half);
        if (direct_ || half.data.mesh || !shown(half)) continue;
        request_mesh(half.data, priority);
        ready = false;
    }
    if (ready) coarsen(n);
    return ready;
}

void Refiner::State::coarsen_unneeded() {
    std::size_t later = 0;
    for (const Unneeded u : unneeded_) {
        LiveNode* const n = graph_.find(u.id);
        if (n == nullptr || !n->refined || n->needed == frame_) continue;
        const bool ripe = to_the_end_ || frame_ - n->needed > kGrace;
        if (!ripe || LiveGraph::has_refined_child(*n) || (time_is_up() && counters_.coarsened > 0) ||
            !try_coarsen(*n, 0))
            unneeded_[later++] = u;
    }
    unneeded_.erase(unneeded_.begin() + static_cast<std::ptrdiff_t>(later), unneeded_.end());
}

void Refiner::State::coarsen_with_children(LiveNode& n) {
    for (LiveHalf* half : n.child_halves)
        if (half->node->refined) coarsen_with_children(*half->node);
    coarsen(n);
}

// A half in sight whose mesh has not come in time gives way to the coarser half around it. The faces' meshes
// are always there.
void Refiner::State::cover_missing_meshes() {
    if (missing_.empty()) return;
    const auto uncovered = static_cast<double>(std::max<std::size_t>(missing_.size(), 8));
    double milliseconds = 0;
    {
        const Stopwatch watch(milliseconds);
        while (!missing_.empty()) {
            const Half half = *missing_.begin();
            coarsen_with_children(*graph_.find(*parent(half.diamond, half.side)));
            ++counters_.forced_coarse;
        }
    }
    cover_ms_ = risen_or_eased(cover_ms_, milliseconds / uncovered);
}

// Meshes of refined diamonds serve only to coarsen at once.
void Refiner::State::drop_inner_meshes() {
    for (const auto& n : graph_.nodes()) {
        if (!n->refined || n->level == 0) continue;
        for (LiveHalf& half : n->halves) {
            if (!half.data.mesh) continue;
            live_bytes_ -= maker_.mesh_bytes();
            pool_.discard(std::exchange(half.data.mesh, nullptr));
            half.data.published = false;
        }
    }
}

}  // namespace carat
