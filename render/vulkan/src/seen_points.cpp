#include "carat/vulkan/seen_points.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "carat/globe/patch.hpp"
#include "carat/render/vector.hpp"
#include "triangle_order.hpp"

namespace carat {
namespace {

struct Corner {
    Vec3 position;
    double height;
};
using Triangle = std::array<Corner, 3>;

SeenPoint mixed(const Triangle& t, const Vec3& weight) {
    SeenPoint out;
    for (std::size_t k = 0; k < 3; ++k) {
        for (std::size_t c = 0; c < 3; ++c) out.position[c] += weight[k] * t[k].position[c];
        out.height += weight[k] * t[k].height;
    }
    return out;
}

// The sine's square of the angle between a ray and a point; infinite behind the eye.
double off_ray(const Vec3& ray, const Vec3& p) {
    if (!(dot(ray, p) > 0)) return std::numeric_limits<double>::infinity();
    const Vec3 area = cross(ray, p);
    return dot(area, area) / (dot(ray, ray) * dot(p, p));
}

// Of a + t e, 0 <= t <= 1: where the angle with the ray is least. It is stationary in one place.
double nearest_on_edge(const Vec3& ray, const Vec3& a, const Vec3& e) {
    const double da = dot(ray, a), de = dot(ray, e), ae = dot(a, e);
    const double t = (da * ae - de * dot(a, a)) / (de * ae - da * dot(e, e));
    return t >= 0 && t <= 1                                                           ? t
           : off_ray(ray, a) <= off_ray(ray, {a[0] + e[0], a[1] + e[1], a[2] + e[2]}) ? 0
                                                                                      : 1;
}

SeenPoint nearest_to_ray(const Triangle& t, const Vec3& ray) {
    SeenPoint best;
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < 3; ++k) {
        const Corner &a = t[k], &b = t[(k + 1) % 3];
        const double s = nearest_on_edge(ray, a.position, subtract(b.position, a.position));
        Vec3 weight{};
        weight[k] = 1 - s;
        weight[(k + 1) % 3] = s;
        const SeenPoint here = mixed(t, weight);
        const double off = off_ray(ray, here.position);
        if (k > 0 && !(off < least)) continue;
        least = off;
        best = here;
    }
    return best;
}

// Weights of the corners are the volumes that the ray spans with the opposite edges.
SeenPoint point_of(const Triangle& t, const Vec3& ray) {
    Vec3 weight;
    for (std::size_t k = 0; k < 3; ++k) {
        const Vec3 &a = t[(k + 1) % 3].position, &b = t[(k + 2) % 3].position;
        weight[k] = -dot(ray, cross(a, subtract(b, a)));
    }
    const double sum = weight[0] + weight[1] + weight[2];
    for (double& w : weight) w /= sum;
    if (weight[0] >= 0 && weight[1] >= 0 && weight[2] >= 0) return mixed(t, weight);
    return nearest_to_ray(t, ray);
}

class Scene {
  public:
    Scene(const Camera& camera, double unit, int cells, PatchList meshes)
        : camera_(camera), unit_(unit), indices_(drawn_indices(cells)) {
        for (const auto& mesh : meshes)
            meshes_[mesh->half.diamond.bits() * 2 + static_cast<std::uint64_t>(mesh->half.side)] = mesh.get();
    }

    SeenPoint at(int x, int y, std::uint64_t patch, std::uint32_t number) const {
        const PatchMesh& mesh = *meshes_.at(patch);
        const std::size_t side = static_cast<std::size_t>(mesh.half.side);
        const std::uint16_t* corner = &indices_[side * indices_.size() / 2 + 3 * std::size_t{number}];
        Triangle t;
        for (std::size_t k = 0; k < 3; ++k) {
            const PatchVertex& v = mesh.vertices[corner[k]];
            UnitVector offset;
            for (std::size_t c = 0; c < 3; ++c) offset[c] = mesh.anchor[c] - camera_.eye[c] + v.offset[c];
            t[k] = {to_metres(offset, unit_), static_cast<double>(v.height)};
        }
        return point_of(t, camera_.ray(x + 0.5, y + 0.5));
    }

  private:
    const Camera& camera_;
    double unit_;
    std::vector<std::uint16_t> indices_;
    std::unordered_map<std::uint64_t, const PatchMesh*> meshes_;
};

}  // namespace

std::vector<SeenPoint> seen_points(const Frame& frame, const Camera& camera, double unit, int cells,
                                   PatchList meshes) {
    const Scene scene(camera, unit, cells, meshes);
    std::vector<SeenPoint> out(frame.patch.size());
    tbb::parallel_for(0, camera.height, [&](int y) {
        for (int x = 0; x < camera.width; ++x) {
            const auto k = static_cast<std::size_t>(y) * static_cast<std::size_t>(camera.width) +
                           static_cast<std::size_t>(x);
            if (frame.patch[k] != kNoPatch) out[k] = scene.at(x, y, frame.patch[k], frame.triangle[k]);
        }
    });
    return out;
}

}  // namespace carat
