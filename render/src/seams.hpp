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
    explicit Seams(int cells);

    // Preconditions: has a mesh and is not in; is in.
    void add(LiveHalf& half);
    void remove(LiveHalf& half);

    // Works until the time is up, but stitches one seam at least, or until as many published meshes as
    // allowed have been replaced by copies.
    void stitch(Clock::time_point deadline, std::uint64_t copies);
    // Edges and corners left to stitch.
    std::size_t pending() const { return pending_; }

  private:
    struct Use {
        LiveHalf* half;
        int part;
    };
    struct Seam {
        std::vector<Use> uses;  // in ascending order of halves
        bool stale = false;
    };
    using Map = std::unordered_map<LatticePoint, Seam, LatticePointHash>;
    struct Table {
        Map seams;
        std::vector<LatticePoint> stale;  // may name seams that are gone or have been stitched
    };

    void add(Table& table, const LatticePoint& at, LiveHalf& half, int part);
    void remove(Table& table, const LatticePoint& at, LiveHalf& half);
    void spoil(Table& table, const LatticePoint& at, Seam& seam);
    template <class Stitch>
    bool work_through(Table& table, Clock::time_point deadline, Stitch stitch);
    void gather(const Seam& seam);
    void stitch_edge(const Seam& seam);
    void stitch_corner(const Seam& seam);
    PatchMesh& own_mesh(LiveHalf& half);

    int cells_;
    Table edges_, corners_;
    std::size_t pending_ = 0;
    std::uint64_t copies_ = 0;  // left
    bool stitched_ = false;     // anything, in this call
    std::vector<CodedNormal> normals_;
    std::vector<SeamUse> uses_;
};

}  // namespace carat
