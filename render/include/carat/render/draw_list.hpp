// From a repository and a view to the patches to draw.
#pragma once

#include <memory>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/render/cut.hpp"
#include "carat/render/patch_mesh.hpp"
#include "carat/render/view.hpp"

namespace carat {

// What is known of a patch besides its mesh.
struct PatchFacts {
    double error = 0;          // pixels: bound of the distance on screen between the patch and S
    double delta = 0;          // metres: bound of their distance
    bool is_virtual = false;   // below the file's leaves: its inner samples are interpolated or synthesised
    bool synthesised = false;  // with procedural detail
};

struct DrawList {
    std::vector<std::shared_ptr<const PatchMesh>> meshes;  // sorted by half
    CutCounters counters;
    std::vector<PatchFacts> facts = {};  // of each mesh
};

// The unculled patches of the least conforming cut in which no unculled half exceeds the threshold (pixels, >
// 0), nor, if spacing is not 0, has samples further apart on screen than `spacing` pixels while the file has
// finer ones. A pure function of (file, view, threshold, spacing), the milliseconds apart. The view's unit
// must be length_unit() of the file's body. Throws Error(usage) otherwise, and what the repository throws.
// Uses the threads of the current TBB arena.
// colour, if not null, is draped over the relief: one cut serves both, the union of what each asks for. Of
// the same body and n(), else Error(usage).
// detail, if not null: of this file; part of the surface.
DrawList converged_cut(const Repository& repository, const View& view, double threshold, double spacing = 0,
                       std::shared_ptr<const ColourRepository> colour = nullptr,
                       const Detail* detail = nullptr);
// Of all that is drawn, detail included or not: heights for a Visibility, metres.
Visibility visibility_of(const RepositoryHeader& header, const Ellipsoid& body, const View& view,
                         double threshold, const Detail* detail);
// Throws Error(usage) naming what differs if the colours are of another body or n().
void check_colours_fit(const ColourRepository& colour, const RepositoryHeader& relief);

// The patches of a cut of a repository with that header and body, whose heights it consumes.
DrawList build_draw_list(const RepositoryHeader& header, const Ellipsoid& body, Cut cut,
                         std::shared_ptr<const ColourRepository> colour = nullptr);

}  // namespace carat
