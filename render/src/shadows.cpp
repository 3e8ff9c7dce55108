#include "carat/render/shadows.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "carat/globe/error.hpp"
#include "carat/render/octahedral.hpp"
#include "carat/render/vector.hpp"
#include "stopwatch.hpp"
#include "sun_view.hpp"

namespace carat {
namespace {

constexpr std::uint32_t kColourBits = 0xFFFFFF;
constexpr double kSunDistance =
    1000;  // semi-major axes: rays of the view that selects are parallel to 1/1000

// Vertices by doublings of their distance from the eye.
class Rings {
  public:
    Rings(const DrawList& list, const SunFrame& frame) : frame_(frame) {
        double least = std::numeric_limits<double>::infinity(), greatest = 0;
        for (const auto& mesh : list.meshes)
            for (const PatchVertex& v : mesh->vertices) {
                const double d = length(frame.from_eye(*mesh, v));
                least = std::min(least, d);
                greatest = std::max(greatest, d);
            }
        nearest_ = std::max(least, greatest * 0x1p-20);
        rectangles_.resize(static_cast<std::size_t>(ring(greatest)) + 1);
        for (const auto& mesh : list.meshes)
            for (const PatchVertex& v : mesh->vertices) {
                const Vec3 p = frame.from_eye(*mesh, v);
                rectangles_[static_cast<std::size_t>(ring(length(p)))].include(frame.across(p));
            }
    }

    int count() const { return static_cast<int>(rectangles_.size()); }
    const SunRectangle& rectangle(int ring) const { return rectangles_[static_cast<std::size_t>(ring)]; }
    double begin(int ring) const { return std::ldexp(nearest_, ring); }
    int ring(double distance) const {
        return distance <= nearest_ ? 0 : static_cast<int>(std::log2(distance / nearest_));
    }

  private:
    const SunFrame& frame_;
    double nearest_ = 0;
    std::vector<SunRectangle> rectangles_;
};

// The shares of the vertices of one ring.
void look_up(PatchMesh& mesh, int ring, const Rings& rings, const SunFrame& frame, const SunView& sun) {
    const double error = kShadowError * sun.cell();
    for (std::size_t k = 0; k < mesh.vertices.size(); ++k) {
        const Vec3 p = frame.from_eye(mesh, mesh.vertices[k]);
        if (rings.ring(length(p)) != ring) continue;
        const double cosine = dot(decode_octahedral(mesh.vertices[k].normal), frame.sun);
        const bool lit = cosine > 0 && !sun.hidden(frame.across(p), error / cosine);
        mesh.colours[k] = (mesh.colours[k] & kColourBits) | (lit ? ~kColourBits : 0);
    }
}

std::shared_ptr<PatchMesh> copy_with_colours(const PatchMesh& mesh) {
    auto copy = std::make_shared<PatchMesh>(mesh);
    if (copy->colours.empty()) copy->colours.assign(copy->vertices.size(), kColourBits);
    return copy;
}

}  // namespace

ShadowCounters cast_shadows(DrawList& list, const Repository& repository, const View& view, const Vec3& sun,
                            const Detail* detail) {
    ShadowCounters counters;
    if (list.meshes.empty()) return counters;
    const Stopwatch watch(counters.milliseconds);
    const int cells = repository.header().cells();
    const Ellipsoid body = repository.header().ellipsoid();
    const SunFrame frame = SunFrame::make(view.camera().eye, view.unit(), sun);
    const Rings rings(list, frame);
    std::vector<std::shared_ptr<PatchMesh>> meshes(list.meshes.size());
    tbb::parallel_for(std::size_t{0}, meshes.size(),
                      [&](std::size_t k) { meshes[k] = copy_with_colours(*list.meshes[k]); });
    for (int ring = 0; ring < rings.count(); ++ring) {
        SunRectangle where = rings.rectangle(ring);
        if (where.empty()) continue;
        const double pixel = rings.begin(ring) / view.focal_pixels();
        const double cell = std::max({pixel, where.side(0) / kShadowCells, where.side(1) / kShadowCells});
        where.grow(cell + 2 * std::max(where.side(0), where.side(1)) / kSunDistance);
        SunView from_sun(frame, where, cell);
        const View far(from_sun.camera(kSunDistance * body.a()), view.unit());
        const DrawList casters = converged_cut(repository, far, kShadowError, 0, nullptr, detail);
        from_sun.fill(casters.meshes, cells);
        tbb::parallel_for(std::size_t{0}, meshes.size(),
                          [&](std::size_t k) { look_up(*meshes[k], ring, rings, frame, from_sun); });
        ++counters.views;
        counters.triangles += casters.meshes.size() * static_cast<std::size_t>(cells * cells);
    }
    list.meshes.assign(meshes.begin(), meshes.end());
    return counters;
}

}  // namespace carat
