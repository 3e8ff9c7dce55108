#include "cut_graph.hpp"

namespace carat {

CutGraph::CutGraph(const Repository& repository) : repository_(repository) {
    for (int face = 0; face < kFaces; ++face) {
        CutNode& root = node(root_diamond(face), 0);
        add_half(root, 0, true);
        add_half(root, 1, true);
    }
}

CutNode& CutGraph::node(DiamondId id, int level) {
    std::unique_ptr<CutNode>& slot = nodes_[id];
    if (!slot) {
        slot = std::make_unique<CutNode>();
        slot->id = id;
        slot->level = level;
        slot->in_file = level < repository_.header().deepest_level && repository_.refined(id);
        for (const int side : {0, 1}) {
            CutHalf& half = slot->halves[static_cast<std::size_t>(side)];
            half.node = slot.get();
            half.side = side;
        }
    }
    return *slot;
}

void CutGraph::add_half(CutNode& n, int side, bool in_file) {
    CutHalf& half = n.halves[static_cast<std::size_t>(side)];
    half.exists = true;
    half.in_file = in_file;
    new_halves_.push_back(&half);
}

void CutGraph::refine(CutNode& n) {
    if (n.refined) return;
    n.refined = true;
    ++refined_;
    for (const int side : {0, 1})
        if (!n.halves[static_cast<std::size_t>(side)].exists) refine(node(*parent(n.id, side), n.level - 1));
    new_refined_.push_back(&n);
    for (const int side : {0, 1})
        for (const int leg : {0, 1}) {
            const Half child = carat::child_halves({n.id, side})[static_cast<std::size_t>(leg)];
            CutNode& k = node(child.diamond, n.level + 1);
            add_half(k, child.side, n.in_file);
            n.child_halves[static_cast<std::size_t>(2 * side + leg)] =
                &k.halves[static_cast<std::size_t>(child.side)];
        }
}

}  // namespace carat
