// From a body's geodetic latitude and longitude to a raster's coordinates and back.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"
#include "carat/preprocess/layer.hpp"

namespace carat {

// Axis-aligned box in a CRS's own coordinates.
struct CrsBox {
    double min_x, min_y, max_x, max_y;
};

// Thread-safe. Coordinates in "traditional GIS" order: longitude or easting first.
class Crs {
  public:
    // True if a CRS, given as WKT, says that heights are above the ellipsoid (a geographic 3-D CRS).
    static bool has_ellipsoidal_heights(const std::string& wkt);
    // Longitude and latitude in degrees on the body's own datum.
    static std::shared_ptr<const Crs> plain();
    // A CRS given as WKT; box is where it will be used, which picks the datum transformation. `file` names
    // the raster in errors (usage: another body, not a map's CRS, unknown to PROJ) and warnings.
    static std::shared_ptr<const Crs> of_wkt(const std::string& wkt, const CrsBox& box, const Ellipsoid& body,
                                             LatitudeKind latitude, const std::string& file,
                                             std::vector<std::string>& warnings);
    virtual ~Crs() = default;

    // Degrees in; non-finite coordinates out where the CRS has no such place.
    virtual void forward(std::span<const double> lat, std::span<const double> lon, std::span<double> x,
                         std::span<double> y) const = 0;
    // In place: x becomes longitude, y latitude, degrees; non-finite where there is no such place.
    virtual void inverse(std::span<double> x, std::span<double> y) const = 0;
    // True if forward() is the identity (x = lon, y = lat).
    virtual bool is_plain() const { return false; }
    // True if forward() is PROJ's work.
    virtual bool is_costly() const { return false; }
    // A full turn of longitude in the CRS's units if it is geographic, else 0.
    double turn() const { return turn_; }
    // PROJ's name of the datum transformation; "" if none was needed.
    const std::string& transformation() const { return transformation_; }

    // The place as a geodetic normal; nothing where the CRS has no such place.
    std::optional<Vec3> normal(double x, double y) const;

  protected:
    double turn_ = 0;
    std::string transformation_;
};

}  // namespace carat
