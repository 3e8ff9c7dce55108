// The border normals of drawn patches, kept up to date while patches come and go.
#pragma once

#include <chrono>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "live_graph.hpp"
#include "seam_normals.hpp"

namespace carat {

// Not thread-safe. The same normals as stitch_normals() over the same patches, once nothing is left to do.
class Seams {
  public:
    using Clock = std::chrono::steady_clock;
    // The heap outlives this.
    Seams(int cells, FrameHeap& heap);

    // Preconditions: has a mesh and is not in; is in.
    void add(LiveHalf& half);
    void remove(LiveHalf& half);

    // What stitching may cost. Published meshes are replaced by copies, and those they replace go to `old`.
    struct Limits {
        Clock::time_point deadline;   // one seam at least
        std::uint64_t copies = 0;     // but for the first seam's
        bool only_spares = false;     // copies are made in spare meshes alone
        std::size_t spares_left = 0;  // then so many are not for this
    };
    void stitch(const Limits& limits, std::pmr::vector<std::shared_ptr<PatchMesh>>& spares,
                std::pmr::vector<std::shared_ptr<PatchMesh>>& old);
    // Edges and corners left to stitch.
    std::size_t pending() const { return pending_; }

  private:
    static constexpr std::size_t kRoom = 1 << 14;  // seams before tables grow
    struct Use {
        LiveHalf* half;
        int part;
    };
    struct Seam {
        explicit Seam(FrameHeap* heap) : uses(heap) {}
        std::pmr::vector<Use> uses;  // in ascending order of halves
        bool stale = false;
    };
    struct Table {
        explicit Table(FrameHeap* heap) : seams(kRoom, heap), stale(heap) {}
        std::pmr::unordered_map<LatticePoint, Seam, LatticePointHash> seams;
        std::pmr::vector<LatticePoint> stale;  // may name seams that are gone or have been stitched
    };

    void add(Table& table, const LatticePoint& at, LiveHalf& half, int part);
    void remove(Table& table, const LatticePoint& at, LiveHalf& half);
    void spoil(Table& table, const LatticePoint& at, Seam& seam);
    template <class Stitch>
    bool work_through(Table& table, const Limits& limits, Stitch stitch);
    void gather(const Seam& seam);
    void stitch_edge(const Seam& seam);
    void stitch_corner(const Seam& seam);
    PatchMesh& own_mesh(LiveHalf& half);

    int cells_;
    FrameHeap* heap_;
    Table edges_{heap_}, corners_{heap_};
    std::size_t pending_ = 0;
    std::uint64_t copies_ = 0;  // left
    bool stitched_ = false;     // anything, in this call
    std::vector<CodedNormal> normals_;
    std::pmr::vector<SeamUse> uses_{heap_};
    std::pmr::vector<std::shared_ptr<PatchMesh>>*spares_ = nullptr, *old_ = nullptr;  // in this call
};

}  // namespace carat
