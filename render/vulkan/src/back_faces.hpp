// Patches all of whose triangles face away from the eye: what the device would throw away triangle by
// triangle.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>

#include "carat/render/patch_mesh.hpp"

namespace carat {

// Contains the normals of all triangles of a patch, as drawn. Metres, body axes.
struct TriangleCone {
    Vec3 axis{};         // unit
    double cosine = -1;  // of the greatest angle of a normal from the axis
    Vec3 centre{};       // of a ball that contains the patch, from its anchor
    double radius = 0;
};
TriangleCone triangle_cone(const PatchMesh& mesh, int cells, double metres_per_unit);

// Whether every triangle faces away from an eye at `eye` (from the patch's anchor, metres) by an angle whose
// sine is at least kFacingMargin: more than the roundings of a device.
inline constexpr double kFacingMargin = 0.01;
bool faces_away(const TriangleCone& cone, const Vec3& eye);

// Cones of the meshes that seem to face away, each made once. Not thread-safe.
class BackFaces {
  public:
    BackFaces(int cells, double metres_per_unit) : cells_(cells), unit_(metres_per_unit) {}

    // Begins a frame; forgets meshes that no frame has asked about for a while.
    void begin();
    // True only if the mesh faces away. At most kConesAFrame cones are made between two begin(); a mesh whose
    // cone is still to be made does not count.
    bool faces_away(const std::shared_ptr<const PatchMesh>& mesh, const UnitVector& eye);

    static constexpr int kConesAFrame = 64;  // 2 ms

  private:
    struct Entry {
        std::weak_ptr<const PatchMesh> mesh;
        Vec3 middle{}, normal{};  // a vertex amid the patch, from the anchor
        std::optional<TriangleCone> cone;
        std::uint64_t used = 0;
    };
    Entry make_entry(const std::shared_ptr<const PatchMesh>& mesh) const;

    int cells_;
    double unit_;
    std::unordered_map<Half, Entry, HalfHash> entries_;
    std::uint64_t frame_ = 0;
    int left_ = 0;
};

}  // namespace carat
