#include "live_graph.hpp"

#include <algorithm>
#include <cassert>
#include <utility>

namespace carat {
namespace {

void place_half(LiveHalf& slot, ChildHalf data) {
    slot.exists = true;
    slot.in_seams = false;
    slot.judged = 0;
    slot.listed = 0;
    slot.judgement = {};
    slot.data = std::move(data);
}

}  // namespace

LiveGraph::LiveGraph(const RefinementMaker& maker, FrameHeap& heap) : heap_(heap) {
    for (int face = 0; face < kFaces; ++face) {
        LiveNode& n = node(root_diamond(face), 0);
        std::array<ChildHalf, 2> halves = maker.face(face);
        for (const std::size_t side : {0u, 1u}) place_half(n.halves[side], std::move(halves[side]));
    }
}

LiveNode* LiveGraph::find(DiamondId id) const {
    const auto it = by_id_.find(id);
    return it == by_id_.end() ? nullptr : it->second;
}

LiveNode& LiveGraph::node(DiamondId id, int level) {
    LiveNode*& slot = by_id_[id];
    if (slot == nullptr) {
        nodes_.emplace_back(std::pmr::polymorphic_allocator<>(&heap_).new_object<LiveNode>(), End{&heap_});
        slot = nodes_.back().get();
        slot->id = id;
        slot->level = level;
        slot->place = nodes_.size() - 1;
        for (const int side : {0, 1}) {
            LiveHalf& half = slot->halves[static_cast<std::size_t>(side)];
            half.node = slot;
            half.side = side;
            half.data.half = {id, side};
        }
    }
    return *slot;
}

void LiveGraph::remove_if_void(LiveNode& n) {
    if (n.halves[0].exists || n.halves[1].exists) return;
    by_id_.erase(n.id);
    const std::size_t place = n.place;
    nodes_[place].swap(nodes_.back());
    nodes_[place]->place = place;
    nodes_.pop_back();
}

void LiveGraph::install(LiveNode& n, std::unique_ptr<Refinement> refinement) {
    assert(n.complete() && !n.refined && refinement->id == n.id);
    n.refined = true;
    ++refined_;
    for (std::size_t k = 0; k < 4; ++k) {
        ChildHalf& child = refinement->children[k];
        LiveNode& node_of = node(child.half.diamond, n.level + 1);
        n.child_halves[k] = &node_of.halves[static_cast<std::size_t>(child.half.side)];
        place_half(*n.child_halves[k], std::move(child));
    }
    empty_.push_back(std::move(refinement));
}

std::unique_ptr<Refinement> LiveGraph::coarsen(LiveNode& n) {
    assert(n.refined && !has_refined_child(n));
    std::unique_ptr<Refinement> out = std::move(empty_.back());
    empty_.pop_back();
    out->id = n.id;
    out->by_file = n.by_file();
    n.refined = false;
    --refined_;
    for (std::size_t k = 0; k < 4; ++k) {
        LiveHalf& child = *n.child_halves[k];
        assert(!child.in_seams);
        out->children[k] = std::move(child.data);
        child.exists = false;
        child.data = {};
        child.data.half = out->children[k].half;
    }
    // Two of the child halves may belong to one diamond.
    for (LiveHalf*& child : n.child_halves) {
        LiveNode& of = *child->node;
        LiveHalf* const gone = std::exchange(child, nullptr);
        if (std::none_of(n.child_halves.begin(), n.child_halves.end(),
                         [&](const LiveHalf* h) { return h != nullptr && h != gone && h->node == &of; }))
            remove_if_void(of);
    }
    return out;
}

bool LiveGraph::has_refined_child(const LiveNode& n) {
    return std::any_of(n.child_halves.begin(), n.child_halves.end(),
                       [](const LiveHalf* h) { return h != nullptr && h->node->refined; });
}

}  // namespace carat
