// Views of all manners over a file: from orbit, oblique, grazing, near the ground; anywhere, and at poles,
// cube corners and edges, the antimeridian. The same for the same seed.
#pragma once

#include <memory>
#include <optional>
#include <random>

#include "carat/codec/surface.hpp"
#include "carat/render/view.hpp"

namespace carat::bench {

class RandomViews {
  public:
    // `place`: half of the views are within a degree of it. The eye is 3 m above the ground at least.
    RandomViews(std::shared_ptr<const Repository> repository, unsigned seed, int width, int height,
                const std::optional<Geodetic>& place = {});

    ViewRequest next();

    enum class Manner : std::uint8_t { globe, oblique, grazing, ground };
    // A view of that manner from above a place.
    ViewRequest from(const Geodetic& place, Manner manner);
    // A place within so many degrees of latitude and of longitude.
    Geodetic around(const Geodetic& at, double degrees);
    double share(double from, double to);   // evenly between
    double factor(double from, double to);  // evenly between the logarithms

    const Surface& surface() const { return surface_; }

  private:
    Geodetic next_place();

    Surface surface_;
    Ellipsoid body_;
    std::mt19937_64 random_;
    int width_, height_;
    std::optional<Geodetic> place_;
    std::uint64_t count_ = 0;
};

}  // namespace carat::bench
