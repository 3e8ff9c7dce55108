// Where the samples of a raster lie: body <-> pixel coordinates, the wrap in longitude and the poles.
//
// Pixel coordinates (u, v): the raster is [0, width] x [0, height], sample (c, r) lies at (c + 1/2, r + 1/2).
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "carat/globe/ellipsoid.hpp"
#include "crs.hpp"
#include "pixel_cells.hpp"

namespace carat {

// How the rows end at a pole (only rasters that wrap round).
struct PoleEnd {
    bool reached = false;
    std::int64_t row = 0;       // the last row that is not at the pole itself
    double distance = 0;        // from that row to the pole, in rows
    std::int64_t mean_row = 0;  // the row whose mean is the height of the pole
};

// Thread-safe.
class Frame {
  public:
    // transform: GDAL's six numbers, pixel edges to CRS. Throws Error(usage) naming the file if it cannot be
    // inverted.
    Frame(std::shared_ptr<const Crs> crs, const std::array<double, 6>& transform, std::int64_t width,
          std::int64_t height, const std::string& file);

    std::int64_t width() const { return width_; }
    std::int64_t height() const { return height_; }
    // Columns in a full turn of longitude, if the raster has that many; else 0.
    std::int64_t period() const { return period_; }
    const PoleEnd& top() const { return top_; }
    const PoleEnd& bottom() const { return bottom_; }
    // True if spacing depends on the row alone.
    bool rows_are_parallels() const { return crs_->turn() > 0 && axis_aligned_; }
    const Crs& crs() const { return *crs_; }
    const std::array<double, 6>& transform() const { return transform_; }

    // Pixel coordinates of places in degrees; u = NaN outside the raster. Where that is PROJ's work they are
    // interpolated, at most PixelCells::kBound pixels off.
    void to_pixels(std::span<const double> lat, std::span<const double> lon, std::span<double> u,
                   std::span<double> v) const;
    // The same, exact and not cut to the raster. May be non-finite.
    void to_unbounded_pixels(std::span<const double> lat, std::span<const double> lon, std::span<double> u,
                             std::span<double> v) const;
    std::optional<Vec3> normal(double u, double v) const;

    // max(sqrt(dx dy), max(dx, dy)/2) in metres at pixel coordinates; nothing where the CRS has no such
    // place.
    std::optional<double> spacing(const Ellipsoid& body, double u, double v) const;

  private:
    void find_wrap();
    void find_cells();
    DegreeBox box(double middle) const;
    void find_period();
    void find_poles();

    std::shared_ptr<const Crs> crs_;
    std::array<double, 6> transform_, inverse_{};
    std::int64_t width_, height_, period_ = 0;
    bool axis_aligned_;
    double west_ = 0;  // longitudes are brought into [west_, west_ + turn)
    PoleEnd top_, bottom_;
    std::optional<PixelCells> cells_;  // where PROJ is asked
};

// Latitude and longitude in degrees of unit normals: one formula for every caller, exact at the poles.
void to_degrees(std::span<const Vec3> n, std::span<double> lat, std::span<double> lon);

}  // namespace carat
