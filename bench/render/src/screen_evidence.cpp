#include "carat/bench/screen_evidence.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/vector.hpp"

namespace carat::bench {

SurfaceRays::SurfaceRays(const std::shared_ptr<const Repository>& file)
    : surface_(file),
      body_(file->header().ellipsoid()),
      highest_(body_.a() + file->header().max_height * file->header().quantum) {}

SurfaceRays::Above SurfaceRays::above(const Vec3& point) const {
    const Ellipsoid::NormalHeight at = body_.normal_height(point);
    const Surface::Sample s = surface_.sample(lattice_position(at.normal));
    return {at.normal, at.height - s.height, s.height, s.spacing};
}

bool SurfaceRays::first_hit(const Vec3& eye, const Vec3& ray, Hit& hit) const {
    // Into the ball that holds everything, and out of it.
    const double middle = -dot(eye, ray), square = dot(eye, eye) - middle * middle;
    if (square > highest_ * highest_) return false;
    const double half = std::sqrt(highest_ * highest_ - square);
    const auto at = [&](double t) { return add(eye, scale(t, ray)); };
    double before = std::max(0.0, middle - half);
    for (double t = before; t <= middle + half;) {
        const Above here = above(at(t));
        const double least = std::max(1e-4, 1e-4 * t);
        if (here.by > 0) {
            before = t;
            t += std::max({0.3 * here.by, here.spacing / 32, least});
            continue;
        }
        for (double below = t; below - before > least / 16;) {
            const double mid = 0.5 * (before + below);
            (above(at(mid)).by > 0 ? before : below) = mid;
        }
        const Above there = above(at(before));
        hit = {body_.position(there.normal, there.ground), there.normal};
        return true;
    }
    return false;
}

DrawnPatches::DrawnPatches(const std::vector<std::shared_ptr<const PatchMesh>>& meshes, int cells,
                           double unit)
    : cells_(cells), unit_(unit) {
    for (const auto& mesh : meshes) {
        meshes_.emplace(mesh->half, mesh.get());
        deepest_ = std::max(deepest_, mesh->half.diamond.level());
    }
}

double DrawnPatches::distance(const SurfaceRays::Hit& hit) const {
    const RealLattice place = lattice_position(hit.normal);
    for (int level = 0; level <= deepest_; ++level) {
        const Location at = locate(place, level);
        const auto found = meshes_.find(at.half);
        if (found == meshes_.end()) continue;
        const PatchMesh& mesh = *found->second;
        const TriangleWeights w = triangle_weights(at.s * cells_, at.t * cells_, cells_);
        Vec3 drawn{};
        for (std::size_t k = 0; k < 3; ++k) {
            const auto [i, j] = w.vertex[k];
            // A corner beyond the diagonal has no weight.
            if (w.weight[k] == 0) continue;
            const bool straight = at.half.side == 0;
            const auto& v = mesh.vertices[half_vertex_index(straight ? i : j, straight ? j : i)];
            for (std::size_t axis = 0; axis < 3; ++axis)
                drawn[axis] += w.weight[k] * unit_ * static_cast<double>(mesh.anchor[axis] + v.offset[axis]);
        }
        return length(subtract(drawn, hit.point));
    }
    return std::numeric_limits<double>::infinity();
}

}  // namespace carat::bench
