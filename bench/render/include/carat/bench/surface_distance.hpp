// How far points that were drawn lie from the surface of a file.
#pragma once

#include <memory>
#include <vector>

#include "carat/codec/surface.hpp"
#include "carat/render/view.hpp"

namespace carat::bench {

// Thread-safe.
class SurfaceDistance {
  public:
    explicit SurfaceDistance(const std::shared_ptr<const Repository>& file);

    // Metres between a point (body frame) and S: the least distance to some points of S, beneath it and where
    // S as a plane would be nearest; never less than the true distance.
    double operator()(const Vec3& point) const;

  private:
    struct Place {
        Vec3 normal{};
        double height = 0, spacing = 0;
    };
    Place place(const Vec3& normal) const;

    Surface surface_;
    Ellipsoid body_;
};

// The greatest distance on the screen, pixels, that `metres` from a point can be seen as: f d sec(theta) / z.
double seen_as(const View& view, const Vec3& point, double metres);

struct ErrorSpread {
    double max = 0, p999 = 0, rms = 0;
};
ErrorSpread error_spread(std::vector<double> errors);

}  // namespace carat::bench
