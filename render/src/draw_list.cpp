#include "carat/render/draw_list.hpp"

#include <tbb/parallel_for.h>

#include "carat/globe/error.hpp"
#include "carat/render/patch_builder.hpp"
#include "stopwatch.hpp"

namespace carat {

DrawList build_draw_list(const RepositoryHeader& header, const Ellipsoid& body, Cut cut) {
    DrawList list{{}, cut.counters};
    const Stopwatch watch(list.counters.build_ms);
    std::erase_if(cut.frontier, [](const FrontierHalf& h) { return h.culled != Culled::none; });

    const PatchBuilder builder(body, header.quantum, header.cells());
    std::vector<std::shared_ptr<PatchMesh>> patches(cut.frontier.size());
    tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t k) {
        patches[k] = builder.build(cut.frontier[k].half, cut.frontier[k].heights);
        cut.frontier[k].heights = {};
    });
    stitch_normals(header.cells(), patches);
    list.meshes.assign(patches.begin(), patches.end());
    return list;
}

DrawList converged_cut(const Repository& repository, const View& view, double threshold, double spacing) {
    const RepositoryHeader& header = repository.header();
    const Ellipsoid body = header.ellipsoid();
    if (view.unit() != length_unit(body))
        throw Error(ErrorCode::usage, "the view is of another body than the file");
    const Visibility visibility(view, body, header.min_height * header.quantum,
                                header.max_height * header.quantum, threshold);
    return build_draw_list(header, body, select_cut(repository, visibility, threshold, spacing));
}

}  // namespace carat
