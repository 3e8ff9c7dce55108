#include <algorithm>
#include <cmath>

#include "refiner_state.hpp"

namespace carat {

bool Refiner::State::Candidate::operator<(const Candidate& other) const {
    if (priority != other.priority) return priority < other.priority;
    if (level != other.level) return level > other.level;
    return id > other.id;
}

bool Refiner::State::Coarsenable::operator<(const Coarsenable& other) const {
    if (needed != other.needed) return needed;
    if (error != other.error) return error > other.error;
    if (level != other.level) return level < other.level;
    return id > other.id;
}

// The least cut for the view, as far as its halves exist: from the faces down, a half that demands refinement
// needs its diamond refined, and a diamond needs both parents refined.
void Refiner::State::select() {
    open_.clear();
    for (int face = 0; face < kFaces; ++face)
        for (LiveHalf& half : graph_.find(root_diamond(face))->halves) open_.push_back(&half);
    work_through();

    drawn_ = uploads_ = 0;
    unneeded_ = false;
    for (const auto& n : graph_.nodes()) {
        if (n->refined) {
            if (n->needed != frame_ && ripe(*n)) unneeded_ = true;
            continue;
        }
        for (LiveHalf& half : n->halves) {
            if (!half.exists) continue;
            if (half.judged != frame_) judge(half);
            enter_frontier(half);
        }
    }
}

void Refiner::State::work_through() {
    while (!open_.empty()) {
        LiveHalf& half = *open_.back();
        open_.pop_back();
        judge(half);
        if (half.judgement.demands) need(*half.node, priority(half));
    }
}

// Of infinite errors the coarsest first.
double Refiner::State::priority(const LiveHalf& half) {
    if (std::isfinite(half.judgement.error)) return std::min(half.judgement.error, kGreatestPriority);
    return kGreatestPriority * (2 + kDeepestId - half.node->level);
}

void Refiner::State::need(LiveNode& n, double priority) {
    const bool first = n.needed != frame_;
    if (!first && n.priority >= priority) return;
    n.priority = priority;
    n.needed = frame_;
    if (n.level > 0)
        for (const int side : {0, 1}) need(graph_.node(*parent(n.id, side), n.level - 1), priority);
    if (!n.refined && n.complete()) candidates_.push({priority, n.level, n.id});
    if (n.refined && first) open_.insert(open_.end(), n.child_halves.begin(), n.child_halves.end());
}

Judgement Refiner::State::judge(const ChildHalf& child, int level) const {
    return carat::judge(*visibility_, goal_.threshold, goal_.spacing, *child.facts, level < maker_.deepest());
}

void Refiner::State::judge(LiveHalf& half) {
    half.judgement = judge(half.data, half.node->level);
    half.judged = frame_;
}

bool Refiner::State::shown(const Judgement& judgement) const {
    return judgement.culled == Culled::none ||
           (judgement.culled == Culled::frustum ? !options_.skip_frustum : !options_.skip_horizon);
}

void Refiner::State::enter_frontier(LiveHalf& half) {
    if (!shown(half)) return;
    if (!half.visible()) decode_unseen(*half.node);
    ++drawn_;
    if (is_upload(half)) ++uploads_;
    if (!half.data.mesh) add_missing(half);
}

// What is not skipped costs what it would in sight; the cut does not need it.
void Refiner::State::decode_unseen(LiveNode& n) {
    if (!n.complete() || n.needed == frame_ || n.level >= maker_.deepest() || cache_.contains(n.id)) return;
    n.priority = 0;
    request(n);
}

void Refiner::State::leave_frontier(LiveHalf& half) {
    if (half.in_seams) seams_.remove(half);
    if (!shown(half)) return;
    --drawn_;
    if (is_upload(half)) --uploads_;
    remove_missing(half.half());
}

}  // namespace carat
