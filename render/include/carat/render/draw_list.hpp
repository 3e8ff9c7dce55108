// From a repository and a view to the patches to draw.
#pragma once

#include <memory>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/render/cut.hpp"
#include "carat/render/patch_mesh.hpp"
#include "carat/render/view.hpp"

namespace carat {

struct DrawList {
    std::vector<std::shared_ptr<const PatchMesh>> meshes;  // sorted by half
    CutCounters counters;
};

// The unculled patches of the least conforming cut in which no unculled half exceeds the threshold (pixels, >
// 0), nor, if spacing is not 0, has samples further apart on screen than `spacing` pixels while the file has
// finer ones. A pure function of (file, view, threshold, spacing), the milliseconds apart. The view's unit
// must be length_unit() of the file's body. Throws Error(usage) otherwise, and what the repository throws.
// Uses the threads of the current TBB arena.
DrawList converged_cut(const Repository& repository, const View& view, double threshold, double spacing = 0);

// The patches of a cut of a repository with that header and body, whose heights it consumes.
DrawList build_draw_list(const RepositoryHeader& header, const Ellipsoid& body, Cut cut);

}  // namespace carat
