// The promises of a cut and its patches, checked against points of S and of the drawn triangles, without the
// bounds that made the cut. For repositories in memory and in files.
#pragma once

#include <array>
#include <functional>
#include <random>

#include "carat/render/draw_list.hpp"

namespace carat::test {

struct TrueSurface {
    const RepositoryHeader& header;
    const Ellipsoid& body;
    // The point of S, metres, at a lattice point of a half.
    std::function<Vec3(const Half&, const LatticePoint&)> point;
};

// Every edge belongs, whole, to exactly two frontier halves; culled ones included, so over the whole sphere.
void expect_conforming(const Cut& cut);

// A vertex has one position, one normal and one height, whichever patch draws it, and every vertex on an edge
// between two drawn patches is a vertex of both. Returns how often a vertex was met again.
// normals: that too; false leaves them out, for a list whose border normals are not stitched yet.
std::uint64_t expect_watertight(const DrawList& list, int cells, bool normals = true);

struct Seen {
    std::uint64_t tested = 0;
    double closest = 0;  // greatest share of the stated error that was met
};
// Random points of drawn triangles and of S at the same lattice places, one of each pair on screen, are no
// further apart there than the patch's stated error.
void expect_true_errors(const TrueSurface& surface, const View& view, const Cut& cut,
                        std::mt19937_64& generator, Seen& seen);

// Random points of S in culled halves are off the screen, or hidden by the ellipsoid that lies below all of
// S. counted: halves by kind of culling.
void expect_culled_unseen(const TrueSurface& surface, const View& view, const Cut& cut,
                          std::mt19937_64& generator, std::array<int, 3>& counted);

// Random rays of the screen that meet the body scaled by `scale` meet a drawn triangle. Returns how many did.
std::uint64_t expect_no_hole(const Ellipsoid& body, double scale, const View& view, const DrawList& list,
                             int cells, std::mt19937_64& generator);

// Random rays of the screen that meet a patch of `hidden` meet one of `drawn` before it. Returns how many
// rays met anything.
std::uint64_t expect_behind(const DrawList& drawn, const DrawList& hidden, const View& view, int cells,
                            std::mt19937_64& generator);

// A random lattice point of a half, and where it is in the half's grid.
struct Place {
    LatticePoint point;
    double x = 0, y = 0;  // index coordinates
};
Place random_place(const Half& half, int cells, std::mt19937_64& generator);

bool on_screen(const View& view, const Vec3& p);

// Vertex of a half in storage order.
LatticePoint lattice_vertex(const Half& half, int cells, int r, int c);

}  // namespace carat::test
