#include <algorithm>
#include <limits>
#include <utility>

#include "refiner_state.hpp"
#include "stopwatch.hpp"

namespace carat {

// The greater of what has come and what has not been asked for yet.
void Refiner::State::refine_candidates() {
    constexpr int kLeast = 16;  // candidates that every frame looks at, for some progress
    for (int looked = 0; !candidates_.empty() || !arrived_.empty(); ++looked) {
        if (time_is_up() && (counters_.installed > 0 || looked >= kLeast)) return;
        const bool fresh_first =
            arrived_.empty() || (!candidates_.empty() && arrived_.top() < candidates_.top());
        const bool may_ask = in_hand_.size() < most_in_hand_;
        if (arrived_.empty() && !may_ask) return;
        Queue<Candidate>& from = fresh_first && may_ask ? candidates_ : arrived_;
        const Candidate c = from.top();
        from.pop();
        const Step step = refine(c);
        full_ = step == Step::full;
        if (step == Step::waits || full_) in_hand_.insert(c.id);  // its refinement is kept
        if (step == Step::done || step == Step::moot) in_hand_.erase(c.id);
        if (step == Step::blocked || full_) return from.push(c);
    }
}

Refiner::State::Step Refiner::State::refine(const Candidate& c) {
    LiveNode* const n = graph_.find(c.id);
    if (n == nullptr || n->refined || !n->complete() || n->needed != frame_) return Step::moot;
    return c.priority == n->priority ? refine(*n) : Step::stale;
}

Refiner::State::Step Refiner::State::refine(LiveNode& n) {
    const Refinement* const refinement = cache_.find(n.id);
    const Load change = load_of_refining(n, refinement);
    if (!choose_room(n, change)) return Step::full;
    if (refinement == nullptr) {
        request(n);
        return Step::waits;
    }
    if (!direct_ && !meshes_ready(n, *refinement)) return Step::waits;
    if (uploads_ + change.uploads > most_.uploads && counters_.installed > 0) return Step::full;
    if (const Step room = make_room(n); room != Step::done) return room;
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

void Refiner::State::install(LiveNode& n) {
    for (LiveHalf& half : n.halves) leave_frontier(half);
    std::unique_ptr<Refinement> refinement = cache_.extract(n.id);
    live_bytes_ += bytes_of(*refinement);
    for (const ChildHalf& child : refinement->children) height_bytes_ += bytes_of_heights(child);
    graph_.install(n, std::move(refinement));
    ++counters_.installed;
    open_.assign(n.child_halves.begin(), n.child_halves.end());
    work_through();
    for (LiveHalf* half : n.child_halves) {
        enter_frontier(*half);
        // Needed before it was complete.
        const LiveNode& child = *half->node;
        if (child.needed == frame_ && child.complete())
            candidates_.push({child.priority, child.level, child.id});
    }
    enqueue(n);
}

void Refiner::State::coarsen(LiveNode& n) {
    for (LiveHalf* half : n.child_halves) leave_frontier(*half);
    std::unique_ptr<Refinement> refinement = graph_.coarsen(n);
    live_bytes_ -= bytes_of(*refinement);
    for (const ChildHalf& child : refinement->children) height_bytes_ -= bytes_of_heights(child);
    discard(cache_.insert(std::move(refinement)));
    ++counters_.coarsened;
    for (LiveHalf& half : n.halves) {
        if (half.judged != frame_) judge(half);
        enter_frontier(half);
    }
    enqueue_parents(n);
}

// Whether the meshes that coarsening uncovers are there; asks for them otherwise, or makes them here.
bool Refiner::State::uncover(LiveNode& n, double priority, bool here) {
    bool ready = true;
    for (LiveHalf& half : n.halves) {
        if (n.level > 0 && graph_.find(*parent(n.id, half.side))->chosen) continue;  // goes at once
        if (half.judged != frame_) judge(half);
        if (direct_ || half.data.mesh || !shown(half) || (here && build_here(half, kSparesForMissing)))
            continue;
        request_mesh(half.data, priority);
        ready = false;
    }
    return ready;
}

void Refiner::State::coarsen_with_children(LiveNode& n) {
    for (LiveHalf* half : n.child_halves)
        if (half->node->refined) coarsen_with_children(*half->node);
    coarsen(n);
}

}  // namespace carat
