// What the refinement of one diamond yields: heights, facts and meshes of its four child halves. Made by
// workers, from nothing that a frame changes.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/render/patch_builder.hpp"
#include "half_bounds.hpp"

namespace carat {

struct ChildHalf {
    Half half;
    bool refined_by_file = false;  // its diamond
    std::shared_ptr<const HalfHeights> heights;
    std::shared_ptr<const HalfFacts> facts;
    std::shared_ptr<PatchMesh> mesh;  // where it was wanted
    bool published = false;           // the mesh has been handed out: it must not change any more
};

struct Refinement {
    DiamondId id;
    bool by_file = false;
    std::array<ChildHalf, 4> children;  // [2h], [2h + 1] tile half h, as child_halves()
};

// Bytes of heights, facts and mesh.
std::uint64_t bytes_of(const ChildHalf& child);

// Which child halves get meshes.
struct MeshWish {
    std::shared_ptr<const Visibility> visibility;  // null: none
    double threshold = 0, spacing = 0;
    bool final_only = false;  // leave out those that demand refinement themselves
    bool culled_too = false;
};

struct RefineWork {
    DiamondId id;
    int level = 0;
    bool by_file = false;
    std::array<std::shared_ptr<const HalfHeights>, 2> heights;
    MeshWish wish;
};

struct WorkTimes {
    double decode_ms = 0, build_ms = 0;
    std::uint64_t built = 0;
};

// Thread-safe.
class RefinementMaker {
  public:
    // colour, detail: null for none; must outlive this, as the repository must.
    RefinementMaker(const Repository& repository, const Ellipsoid& body,
                    const std::shared_ptr<const ColourRepository>& colour = nullptr,
                    const Detail* detail = nullptr);

    // The two halves of a face.
    std::array<ChildHalf, 2> face(int face) const;
    std::unique_ptr<Refinement> refine(const RefineWork& work, WorkTimes& times) const;
    std::shared_ptr<PatchMesh> build(const Half& half, const HalfHeights& heights, WorkTimes& times) const;
    void build(const Half& half, const HalfHeights& heights, PatchMesh& out, WorkTimes& times) const;
    // Meshes of no half in memory that has been touched.
    std::vector<std::shared_ptr<PatchMesh>> spare_meshes(int count) const;

    int deepest() const { return deepest_; }  // level that can be refined
    std::uint64_t mesh_bytes() const;
    bool coloured() const { return coloured_; }

  private:
    void add_facts(ChildHalf& child, HalfHeights heights, bool in_file, int level) const;
    bool wanted(const MeshWish& wish, const ChildHalf& child, int level) const;

    const Repository& repository_;
    const Detail* detail_;
    HalfSurvey survey_;
    PatchBuilder builder_;
    int cells_, deepest_;
    bool coloured_;
};

}  // namespace carat
