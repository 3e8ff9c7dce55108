#include "carat/render/patch_builder.hpp"

#include <cassert>

#include "carat/globe/patch.hpp"
#include "carat/render/octahedral.hpp"
#include "vector.hpp"

namespace carat {
namespace {

// Tangents of one lattice coordinate over a half's grid. The coordinate is origin + i u + j v with u and v
// each 0 or
// +-step, so it takes few values: direction() costs one square root a vertex instead of three tangents.
class AxisTangents {
  public:
    AxisTangents(const HalfFrame& f, int axis, int cells)
        : u_(f.u[axis] == 0  ? 0
             : f.u[axis] > 0 ? 1
                             : -1),
          v_(f.v[axis] == 0  ? 0
             : f.v[axis] > 0 ? 1
                             : -1) {
        const std::int64_t step = std::abs(f.u[axis]) > 0 ? std::abs(f.u[axis]) : std::abs(f.v[axis]);
        assert(f.u[axis] == u_ * step && f.v[axis] == v_ * step);
        least_ = cells * (std::min(u_, 0) + std::min(v_, 0));
        const int greatest = cells * (std::max(u_, 0) + std::max(v_, 0));
        for (int k = least_; k <= greatest; ++k) {
            const std::int64_t x = f.origin[axis] + k * step;
            // Half of an odd grid's square lies outside the half and, at a cube edge, outside the cube.
            tangents_.push_back(std::abs(x) <= kLatticeExtent ? lattice_tangent(static_cast<std::int32_t>(x))
                                                              : 0);
        }
    }
    double at(int i, int j) const { return tangents_[static_cast<std::size_t>(i * u_ + j * v_ - least_)]; }

  private:
    int u_, v_, least_ = 0;
    std::vector<double> tangents_;
};

Vec3 from_units(const UnitVector& p) {
    return {static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2])};
}

UnitVector offset_from(const UnitVector& p, const UnitVector& anchor) {
    return {p[0] - anchor[0], p[1] - anchor[1], p[2] - anchor[2]};
}

// A normal that heights beyond any planet have folded to nothing points outwards all the same.
Vec3 usable(const Vec3& normal, const UnitVector& position) {
    return dot(normal, normal) > 0 ? normal : from_units(position);
}

void interior_normals(PatchMesh& mesh, int cells) {
    const auto at = [&](int r, int c) { return from_units(mesh.vertices[half_vertex_index(r, c)].offset); };
    for (int r = 2; r < cells; ++r)
        for (int c = 1; c < r; ++c) {
            const Vec3 along_r = subtract(at(r + 1, c), at(r - 1, c));
            const Vec3 along_c = subtract(at(r, c + 1), at(r, c - 1));
            // i x j points outwards; r is i on side 0 and j on side 1.
            const Vec3 normal = mesh.half.side == 0 ? cross(along_r, along_c) : cross(along_c, along_r);
            PatchVertex& v = mesh.vertices[half_vertex_index(r, c)];
            const UnitVector position{mesh.anchor[0] + v.offset[0], mesh.anchor[1] + v.offset[1],
                                      mesh.anchor[2] + v.offset[2]};
            v.normal = encode_octahedral(usable(normal, position));
        }
}

}  // namespace

PatchBuilder::PatchBuilder(const Ellipsoid& body, double quantum, int cells)
    : body_(body), quantum_(quantum), unit_(length_unit(body)), cells_(cells) {}

std::shared_ptr<PatchMesh> PatchBuilder::build(const Half& half, const HalfHeights& heights) const {
    assert(heights.size() == half_vertex_count(cells_));
    const HalfFrame frame = half_frame(half, cells_);
    const AxisTangents x(frame, 0, cells_), y(frame, 1, cells_), z(frame, 2, cells_);
    const double metres = quantum_ * kHeightFraction;

    auto out = std::make_shared<PatchMesh>();
    PatchMesh& mesh = *out;
    mesh.half = half;
    mesh.vertices.resize(heights.size());
    std::size_t k = 0;
    for (int r = 0; r <= cells_; ++r)
        for (int c = 0; c <= r; ++c, ++k) {
            const int i = half.side == 0 ? r : c, j = half.side == 0 ? c : r;
            const double height = static_cast<double>(heights[k]) * metres;
            const Vec3 n = direction_from_tangents({x.at(i, j), y.at(i, j), z.at(i, j)});
            mesh.vertices[k].offset = to_units(body_.position(n, height), unit_);
            mesh.vertices[k].height = static_cast<float>(height);
        }
    mesh.anchor = mesh.vertices[half_vertex_index(cells_, 0)].offset;
    for (PatchVertex& v : mesh.vertices) v.offset = offset_from(v.offset, mesh.anchor);
    interior_normals(mesh, cells_);
    return out;
}

}  // namespace carat
