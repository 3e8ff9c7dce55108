// The persistent cut: refined diamonds and their halves, linked to parents and children.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "refinement.hpp"

namespace carat {

struct LiveNode;

struct LiveHalf {
    LiveNode* node = nullptr;
    int side = 0;
    bool exists = false;
    bool in_seams = false;     // its border normals are kept up with its neighbours'
    ChildHalf data;            // of an existing half: heights and facts; a mesh if there was need for one
    std::uint64_t judged = 0;  // frame of the judgement
    Judgement judgement;

    const Half& half() const { return data.half; }
    bool visible() const { return judgement.culled == Culled::none; }
};

struct LiveNode {
    DiamondId id;
    int level = 0;
    bool refined = false;
    std::array<LiveHalf, 2> halves;
    std::array<LiveHalf*, 4> child_halves{};  // while refined: [2h], [2h + 1] tile half h
    std::uint64_t needed = 0;                 // last frame that needed it refined
    double priority = 0;                      // pixels: greatest error that needed it
    std::size_t place = 0;                    // in LiveGraph::nodes()

    bool complete() const { return halves[0].exists && halves[1].exists; }
    bool by_file() const { return halves[0].data.refined_by_file; }  // precondition: complete
};

// Closed upwards at any time. Not thread-safe.
class LiveGraph {
  public:
    explicit LiveGraph(const RefinementMaker& maker);  // the six faces, with meshes

    const std::vector<std::unique_ptr<LiveNode>>& nodes() const { return nodes_; }
    LiveNode* find(DiamondId id) const;
    // Also one that no existing half belongs to yet: remove it with remove_if_void().
    LiveNode& node(DiamondId id, int level);
    void remove_if_void(LiveNode& n);

    // Preconditions: complete, not refined, of this diamond.
    void install(LiveNode& n, Refinement refinement);
    // Preconditions: refined, no child refined, no child half in seams. Removes child nodes left without
    // halves.
    std::unique_ptr<Refinement> coarsen(LiveNode& n);
    static bool has_refined_child(const LiveNode& n);

    std::uint64_t refined() const { return refined_; }

  private:
    std::vector<std::unique_ptr<LiveNode>> nodes_;
    std::unordered_map<DiamondId, LiveNode*, DiamondIdHash> by_id_;
    std::uint64_t refined_ = 0;
};

}  // namespace carat
