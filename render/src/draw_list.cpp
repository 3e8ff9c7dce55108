#include "carat/render/draw_list.hpp"

#include <tbb/parallel_for.h>

#include "carat/globe/error.hpp"
#include "carat/render/patch_builder.hpp"
#include "stopwatch.hpp"

namespace carat {

DrawList build_draw_list(const RepositoryHeader& header, const Ellipsoid& body, Cut cut,
                         std::shared_ptr<const ColourRepository> colour) {
    DrawList list{{}, cut.counters};
    const Stopwatch watch(list.counters.build_ms);
    std::erase_if(cut.frontier, [](const FrontierHalf& h) { return h.culled != Culled::none; });

    for (const FrontierHalf& h : cut.frontier)
        list.facts.push_back({h.error, h.delta, h.is_virtual, h.is_virtual && !h.heights.rough.empty()});

    const PatchBuilder builder(body, header.quantum, header.cells(), std::move(colour));
    std::vector<std::shared_ptr<PatchMesh>> patches(cut.frontier.size());
    tbb::parallel_for(std::size_t{0}, patches.size(), [&](std::size_t k) {
        patches[k] = builder.build(cut.frontier[k].half, cut.frontier[k].heights);
        cut.frontier[k].heights = {};
    });
    stitch_normals(header.cells(), patches);
    list.meshes.assign(patches.begin(), patches.end());
    return list;
}

void check_colours_fit(const ColourRepository& colour, const RepositoryHeader& relief) {
    const RepositoryHeader& c = colour.header();
    if (c.body_a != relief.body_a || c.body_b != relief.body_b)
        throw Error(ErrorCode::usage, "the colours are of another body than the relief");
    if (c.n() != relief.n())
        throw Error(ErrorCode::usage, "the colours have patches of " + std::to_string(c.cells()) +
                                          " cells a side, the relief of " + std::to_string(relief.cells()));
}

Visibility visibility_of(const RepositoryHeader& header, const Ellipsoid& body, const View& view,
                         double threshold, const Detail* detail) {
    const double beyond = detail == nullptr ? 0 : detail->greatest();
    return {view, body, header.min_height * header.quantum - beyond,
            header.max_height * header.quantum + beyond, threshold};
}

DrawList converged_cut(const Repository& repository, const View& view, double threshold, double spacing,
                       std::shared_ptr<const ColourRepository> colour, const Detail* detail) {
    const RepositoryHeader& header = repository.header();
    const Ellipsoid body = header.ellipsoid();
    if (view.unit() != length_unit(body))
        throw Error(ErrorCode::usage, "the view is of another body than the file");
    if (colour) check_colours_fit(*colour, header);
    const Visibility visibility = visibility_of(header, body, view, threshold, detail);
    Cut cut = select_cut(repository, visibility, threshold, spacing, colour.get(), detail);
    return build_draw_list(header, body, std::move(cut), std::move(colour));
}

}  // namespace carat
