#include "refinement.hpp"

#include "carat/globe/patch.hpp"
#include "carat/render/cut.hpp"
#include "stopwatch.hpp"

namespace carat {

std::uint64_t bytes_of(const ChildHalf& child) {
    std::uint64_t bytes = sizeof(ChildHalf) + sizeof(HalfFacts);
    if (child.heights) bytes += child.heights->bytes();
    if (child.mesh)
        bytes += child.mesh->vertices.size() * sizeof(PatchVertex) +
                 child.mesh->colours.size() * sizeof(child.mesh->colours[0]);
    return bytes;
}

RefinementMaker::RefinementMaker(const Repository& repository, const Ellipsoid& body,
                                 const std::shared_ptr<const ColourRepository>& colour, const Detail* detail)
    : repository_(repository),
      detail_(detail),
      survey_(repository, body, colour.get(), detail),
      builder_(body, repository.header().quantum, repository.header().cells(), colour),
      cells_(repository.header().cells()),
      deepest_(deepest_refinable_level(repository.header().log2_cells)),
      coloured_(colour != nullptr) {}

std::uint64_t RefinementMaker::mesh_bytes() const {
    return std::uint64_t{half_vertex_count(cells_)} *
           (sizeof(PatchVertex) + (coloured_ ? sizeof(std::uint32_t) : 0));
}

void RefinementMaker::add_facts(ChildHalf& child, HalfHeights heights, bool in_file, int level) const {
    child.refined_by_file =
        in_file && level < repository_.header().deepest_level && repository_.refined(child.half.diamond);
    if (detail_ != nullptr && in_file && !child.refined_by_file)
        detail_->begin(repository_, child.half, heights);
    child.heights = std::make_shared<const HalfHeights>(std::move(heights));
    child.facts = std::make_shared<const HalfFacts>(
        survey_.facts(child.half, in_file, child.refined_by_file, *child.heights));
}

std::array<ChildHalf, 2> RefinementMaker::face(int face) const {
    std::array<HalfHeights, 2> heights = split(repository_.root(face));
    std::array<ChildHalf, 2> out;
    WorkTimes times;
    for (const std::size_t side : {0u, 1u}) {
        ChildHalf& half = out[side];
        half.half = {root_diamond(face), static_cast<int>(side)};
        add_facts(half, std::move(heights[side]), true, 0);
        half.mesh = build(half.half, *half.heights, times);
    }
    return out;
}

bool RefinementMaker::wanted(const MeshWish& wish, const ChildHalf& child, int level) const {
    if (!wish.visibility) return false;
    const Judgement j = judge(*wish.visibility, wish.threshold, wish.spacing, *child.facts, level < deepest_);
    return (wish.culled_too || j.culled == Culled::none) && !(wish.final_only && j.demands);
}

std::unique_ptr<Refinement> RefinementMaker::refine(const RefineWork& work, WorkTimes& times) const {
    auto out = std::make_unique<Refinement>();
    out->id = work.id;
    out->by_file = work.by_file;
    {
        const Stopwatch watch(times.decode_ms);
        const auto gather = [&](const auto& refined) {
            for (const int side : {0, 1})
                for (const int leg : {0, 1}) {
                    ChildHalf& child = out->children[static_cast<std::size_t>(2 * side + leg)];
                    child.half = child_halves({work.id, side})[static_cast<std::size_t>(leg)];
                    add_facts(child, gather_child(refined, work.id, child.half), work.by_file,
                              work.level + 1);
                }
        };
        if (work.by_file) {
            thread_local Heights whole;
            thread_local RefinedHeights refined;
            whole_heights(*work.heights[0], *work.heights[1], cells_, whole);
            repository_.refine(work.id, whole, refined);
            gather(refined);
        } else if (detail_ != nullptr) {
            thread_local VirtualHeights refined;
            detail_->refine(work.id, work.level, *work.heights[0], *work.heights[1], refined);
            gather(refined);
        } else {
            gather(refine_virtually(*work.heights[0], *work.heights[1], cells_));
        }
    }
    for (ChildHalf& child : out->children)
        if (wanted(work.wish, child, work.level + 1)) child.mesh = build(child.half, *child.heights, times);
    return out;
}

std::shared_ptr<PatchMesh> RefinementMaker::build(const Half& half, const HalfHeights& heights,
                                                  WorkTimes& times) const {
    auto out = std::make_shared<PatchMesh>();
    build(half, heights, *out, times);
    return out;
}

void RefinementMaker::build(const Half& half, const HalfHeights& heights, PatchMesh& out,
                            WorkTimes& times) const {
    const Stopwatch watch(times.build_ms);
    ++times.built;
    builder_.build(half, heights, out);
}

std::vector<std::shared_ptr<PatchMesh>> RefinementMaker::spare_meshes(int count) const {
    std::vector<std::shared_ptr<PatchMesh>> out;
    for (int k = 0; k < count; ++k) {
        out.push_back(std::make_shared<PatchMesh>());
        out.back()->vertices.assign(half_vertex_count(cells_), PatchVertex{});
        if (coloured_) out.back()->colours.assign(half_vertex_count(cells_), 0);
    }
    return out;
}

}  // namespace carat
