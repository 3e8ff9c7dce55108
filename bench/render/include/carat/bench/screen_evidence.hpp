// An independent look at S and at what is drawn of it: rays marched along the heights of a file, and the
// distance of their hits from drawn patches. Knows no bounds, no cut and no culling.
#pragma once

#include <memory>
#include <string>
#include <unordered_map>
#include <vector>

#include "carat/codec/surface.hpp"
#include "carat/render/patch_mesh.hpp"
#include "carat/render/view.hpp"

namespace carat::bench {

// Thread-safe.
class SurfaceRays {
  public:
    explicit SurfaceRays(const std::shared_ptr<const Repository>& file);

    struct Hit {
        Vec3 point{};  // of S, metres
        Vec3 normal{};
    };
    // A point of S where a ray (unit direction) from above S goes below it, the first one but for what is
    // steeper than 73 degrees or shallower than a step, and passed by: steps are three tenths of the height
    // above S, or a thirty-second of the spacing of samples there, or a ten-thousandth of the distance. False
    // if there is none.
    bool first_hit(const Vec3& eye, const Vec3& ray, Hit& hit) const;

  private:
    struct Above {
        Vec3 normal{};
        double by = 0, ground = 0, spacing = 0;  // metres
    };
    Above above(const Vec3& point) const;

    Surface surface_;
    Ellipsoid body_;
    double highest_;  // of S from the centre, metres
};

// Drawn patches, by place.
class DrawnPatches {
  public:
    // unit: metres a length unit of the meshes.
    DrawnPatches(const std::vector<std::shared_ptr<const PatchMesh>>& meshes, int cells, double unit);

    // From a point of S to the point drawn at the same place, no less than to the nearest one; infinite where
    // nothing is drawn.
    double distance(const SurfaceRays::Hit& hit) const;

  private:
    std::unordered_map<Half, const PatchMesh*, HalfHash> meshes_;
    int deepest_ = 0, cells_;
    double unit_;
};

// Views of a file by kind: orbit, oblique, grazing and valley floor near `place`, and from all these heights
// at poles, cube corners and the antimeridian. Kinds take turns; the same for the same seed.
struct KindOfView {
    std::string kind;
    ViewRequest view;
};
std::vector<KindOfView> views_by_kind(const std::shared_ptr<const Repository>& file, int count, unsigned seed,
                                      int width, int height, const Geodetic& place);

}  // namespace carat::bench
