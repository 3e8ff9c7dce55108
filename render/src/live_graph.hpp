// The persistent cut: refined diamonds and their halves, linked to parents and children.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "frame_heap.hpp"
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
    std::uint64_t listed = 0;  // last frame whose list its mesh was in
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
    std::uint64_t queued = 0;                 // frame of its place in the coarsening queue
    bool chosen = false;                      // to be coarsened
    std::size_t place = 0;                    // in LiveGraph::nodes()

    bool complete() const { return halves[0].exists && halves[1].exists; }
    bool by_file() const { return halves[0].data.refined_by_file; }  // precondition: complete
};

// Closed upwards at any time. Not thread-safe.
class LiveGraph {
  public:
    // The six faces, with meshes. The heap outlives this.
    LiveGraph(const RefinementMaker& maker, FrameHeap& heap);

    struct End {
        FrameHeap* heap;
        void operator()(LiveNode* n) const { std::pmr::polymorphic_allocator<>(heap).delete_object(n); }
    };
    using Nodes = std::pmr::vector<std::unique_ptr<LiveNode, End>>;
    const Nodes& nodes() const { return nodes_; }
    LiveNode* find(DiamondId id) const;
    // Also one that no existing half belongs to yet: remove it with remove_if_void().
    LiveNode& node(DiamondId id, int level);
    void remove_if_void(LiveNode& n);

    // Preconditions: complete, not refined, of this diamond. Keeps what is left of it for coarsen().
    void install(LiveNode& n, std::unique_ptr<Refinement> refinement);
    // Preconditions: refined, no child refined, no child half in seams. Removes child nodes left without
    // halves.
    std::unique_ptr<Refinement> coarsen(LiveNode& n);
    static bool has_refined_child(const LiveNode& n);

    std::uint64_t refined() const { return refined_; }

  private:
    static constexpr std::size_t kRoom = 1 << 14;  // nodes before tables grow

    FrameHeap& heap_;
    Nodes nodes_{&heap_};
    std::pmr::unordered_map<DiamondId, LiveNode*, DiamondIdHash> by_id_{kRoom, &heap_};
    std::pmr::vector<std::unique_ptr<Refinement>> empty_{&heap_};
    std::uint64_t refined_ = 0;
};

}  // namespace carat
