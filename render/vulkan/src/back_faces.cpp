#include "back_faces.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "carat/globe/patch.hpp"
#include "carat/render/octahedral.hpp"
#include "carat/render/vector.hpp"

namespace carat {
namespace {

// Unit normals of the triangles, outwards.
std::vector<Vec3> triangle_normals(const PatchMesh& mesh, int cells, double unit) {
    std::vector<Vec3> out;
    for (const auto& corners : half_triangles(mesh.half.side, cells)) {
        const auto at = [&](std::size_t k) { return to_metres(mesh.vertices[corners[k]].offset, unit); };
        const Vec3 a = at(0), n = cross(subtract(at(1), a), subtract(at(2), a));
        const double size = length(n);
        if (size > 0)
            out.push_back({n[0] / size, n[1] / size, n[2] / size});  // one without area is not drawn
    }
    return out;
}

}  // namespace

TriangleCone triangle_cone(const PatchMesh& mesh, int cells, double unit) {
    TriangleCone cone;
    Vec3 low = to_metres(mesh.vertices.front().offset, unit), high = low;
    for (const PatchVertex& v : mesh.vertices) {
        const Vec3 p = to_metres(v.offset, unit);
        for (std::size_t k = 0; k < 3; ++k) {
            low[k] = std::min(low[k], p[k]);
            high[k] = std::max(high[k], p[k]);
        }
    }
    for (std::size_t k = 0; k < 3; ++k) cone.centre[k] = 0.5 * (low[k] + high[k]);
    cone.radius = 0.5 * length(subtract(high, low));

    const std::vector<Vec3> normals = triangle_normals(mesh, cells, unit);
    Vec3 sum{};
    for (const Vec3& n : normals)
        for (std::size_t k = 0; k < 3; ++k) sum[k] += n[k];
    const double size = length(sum);
    if (!(size > 0)) return cone;
    for (std::size_t k = 0; k < 3; ++k) cone.axis[k] = sum[k] / size;
    cone.cosine = 1;
    for (const Vec3& n : normals) cone.cosine = std::min(cone.cosine, dot(cone.axis, n));
    return cone;
}

// With v from the eye to the centre and t the angle between v and the axis, a normal n of the cone has n . v
// >= |v| cos(t + a), and for any point p of the ball n . (p - eye) >= |v| cos(t + a) - r. A triangle faces
// away if that is positive.
bool faces_away(const TriangleCone& cone, const Vec3& eye) {
    if (cone.cosine <= 0) return false;
    const Vec3 v = subtract(cone.centre, eye);
    const double distance = length(v), along = dot(v, cone.axis);
    const double across = std::sqrt(std::max(0.0, distance * distance - along * along));
    const double sine = std::sqrt(std::max(0.0, 1 - cone.cosine * cone.cosine));
    return along * cone.cosine - across * sine - cone.radius > kFacingMargin * distance;
}

void BackFaces::begin() {
    constexpr std::uint64_t kForget = 16;  // frames
    ++frame_;
    left_ = kConesAFrame;
    if (frame_ % kForget == 0)
        std::erase_if(entries_, [&](const auto& e) { return e.second.used + kForget < frame_; });
}

BackFaces::Entry BackFaces::make_entry(const std::shared_ptr<const PatchMesh>& mesh) const {
    // Two thirds down the middle column of the triangle.
    const int row = cells_ / 2 + cells_ / 4, column = cells_ / 4 + cells_ / 8;
    const std::uint32_t index =
        mesh->half.side == 0 ? half_vertex_index(row, column) : half_vertex_index(column, row);
    const PatchVertex& v = mesh->vertices[index];
    return {mesh, to_metres(v.offset, unit_), decode_octahedral(v.normal), {}, frame_};
}

bool BackFaces::faces_away(const std::shared_ptr<const PatchMesh>& mesh, const UnitVector& eye) {
    Entry& e = entries_[mesh->half];
    if (e.mesh.owner_before(mesh) || mesh.owner_before(e.mesh)) e = make_entry(mesh);
    e.used = frame_;
    UnitVector offset{};
    for (std::size_t k = 0; k < 3; ++k) offset[k] = eye[k] - mesh->anchor[k];
    const Vec3 from_anchor = to_metres(offset, unit_), v = subtract(e.middle, from_anchor);
    if (dot(v, e.normal) <= kFacingMargin * length(v)) return false;
    if (!e.cone) {
        if (left_ == 0) return false;
        --left_;
        e.cone = triangle_cone(*mesh, cells_, unit_);
    }
    return carat::faces_away(*e.cone, from_anchor);
}

}  // namespace carat
