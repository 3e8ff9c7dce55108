// The coarsening queue: least error on screen first.
#include <algorithm>
#include <limits>

#include "refiner_state.hpp"

namespace carat {

Refiner::State::Coarsenable Refiner::State::coarsenable(LiveNode& n) {
    if (n.needed == frame_) return {true, n.priority, n.level, n.id};
    double error = 0;
    for (LiveHalf& half : n.halves) {
        if (half.judged != frame_) judge(half);
        error = std::max(error, half.judgement.error);
    }
    return {false, error, n.level, n.id};
}

// Refined, and no child is that is not chosen to be coarsened before.
bool Refiner::State::may_be_next(const LiveNode& n) {
    return n.refined && std::none_of(n.child_halves.begin(), n.child_halves.end(),
                                     [](const LiveHalf* h) { return h->node->refined && !h->node->chosen; });
}

// Most frames need none.
void Refiner::State::fill_queue() {
    if (std::exchange(queue_filled_, true)) return;
    for (const auto& n : graph_.nodes()) enqueue(*n);
}

void Refiner::State::enqueue(LiveNode& n) {
    if (!queue_filled_ || n.queued == frame_) return;
    if (!may_be_next(n)) return;
    n.queued = frame_;
    coarsenable_.push(coarsenable(n));
}

// Null if what is left is needed and not of less error than this. Entries may be of diamonds that have gone,
// have been refined on or have become more important since.
LiveNode* Refiner::State::pop_least(double below) {
    fill_queue();
    while (!coarsenable_.empty()) {
        const Coarsenable c = coarsenable_.top();
        if (c.needed && !(c.error < below)) return nullptr;
        coarsenable_.pop();
        LiveNode* const n = graph_.find(c.id);
        if (n == nullptr || n->queued != frame_) continue;
        n->queued = 0;
        if (!may_be_next(*n)) continue;
        if (n->needed != frame_ || (c.needed && n->priority == c.error)) return n;
        enqueue(*n);
    }
    return nullptr;
}

void Refiner::State::enqueue_parents(const LiveNode& n) {
    if (n.level == 0 || !queue_filled_) return;
    for (const int side : {0, 1}) enqueue(*graph_.find(*parent(n.id, side)));
}

void Refiner::State::put_back(List<DiamondId>& popped) {
    for (const DiamondId id : popped)
        if (LiveNode* const n = graph_.find(id)) enqueue(*n);
    popped.clear();
}

// What has not been needed for a while.
void Refiner::State::coarsen_unneeded() {
    if (!unneeded_) return;
    List<DiamondId> later(&heap_);
    bool stop = false;
    while (!stop) {
        LiveNode* const n = pop_least(-std::numeric_limits<double>::infinity());
        if (n == nullptr) break;
        if (!ripe(*n)) {
            set_aside_.push_back(n->id);
            continue;
        }
        const Load change = load_of_coarsening(*n);
        stop = counters_.coarsened > 0 &&
               (time_is_up() || (change.uploads > 0 && uploads_ + change.uploads > most_.uploads));
        if (!stop && fits(change) && uncover(*n, 0, false))
            coarsen(*n);
        else
            later.push_back(n->id);
    }
    unneeded_ = !later.empty();
    put_back(later);
}

}  // namespace carat
