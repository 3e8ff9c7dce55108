// Oblate ellipsoids of revolution (or spheres), geodetic coordinates, positions in metres.
#pragma once

#include <array>
#include <string>

#include "carat/globe/sphere.hpp"

namespace carat {

// Degrees; latitude in [-90, 90], longitude in [-180, 180].
struct Geodetic {
    double latitude = 0, longitude = 0;
};

// Geodetic normal of a latitude and longitude; exact at multiples of 90 degrees (poles, equator, meridians),
// and longitude -180 equals 180. Any finite longitude. Throws Error(usage) if |latitude| > 90 or not finite.
Vec3 direction(const Geodetic& g);
// Latitude and longitude of a non-zero normal. At a pole longitude is 0. Longitude in [-180, 180].
Geodetic geodetic(const Vec3& n);

class Ellipsoid {
  public:
    // Semi-axes in metres. Throws Error(usage) unless a / 10 <= b <= a and 1 mm <= a <= 1e12 m. Samples the
    // surface for the derivative bounds below, a few milliseconds: make one and pass it on.
    Ellipsoid(double equatorial, double polar, std::string name = "");

    static Ellipsoid earth();  // WGS 84: 6378137 m, 1/298.257223563
    static Ellipsoid moon();   // IAU 2015 sphere, 1737400 m
    static Ellipsoid mars();   // Mars 2000: 3396190 m, 3376200 m
    // "earth", "moon", "mars" or "A,B" in metres. Throws Error(usage) otherwise.
    static Ellipsoid parse(const std::string& text);

    double a() const { return a_; }
    double b() const { return b_; }
    const std::string& name() const { return name_; }  // "" for given semi-axes

    // Point of the surface with unit geodetic normal n, raised by h metres along n. One function, no
    // contraction. Agrees with GeographicLib::Geocentric to below 10 nm up to the size of Earth (measured
    // 3.8 nm, heights -10 to 100 km).
    Vec3 position(const Vec3& n, double h) const;

    struct NormalHeight {
        Vec3 normal{};
        double height = 0;
    };
    // Inverse of position() for points above the evolute: geodetic normal and height in metres
    // (GeographicLib). Throws Error(usage) for non-finite input.
    NormalHeight normal_height(const Vec3& position) const;

    // Smallest and greatest radius of curvature anywhere, metres: b^2/a and a^2/b.
    double min_curvature_radius() const { return b_ * b_ / a_; }
    double max_curvature_radius() const { return a_ * a_ / b_; }

    // Upper bounds over the whole cube-sphere of the second and third directional derivative of the surface
    // point, by angle on a cube face (pi/4 per 2^30 lattice units), metres. For a sphere 1.67 a and
    // 4.7 a.
    double second_derivative_bound() const { return d2_; }
    double third_derivative_bound() const { return d3_; }

    friend bool operator==(const Ellipsoid& l, const Ellipsoid& r) { return l.a_ == r.a_ && l.b_ == r.b_; }

  private:
    double a_, b_;
    double d2_ = 0, d3_ = 0;
    std::string name_;
};

}  // namespace carat
