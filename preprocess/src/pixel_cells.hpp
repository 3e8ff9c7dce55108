// Pixel coordinates of places interpolated between exact ones, for PROJ takes a microsecond a place.
//
//   cells     squares of a lattice fixed for the whole body. Up to 60 degrees of latitude: rows of 2^-k
//             degrees, in each of them columns of 2^(m-k) degrees of longitude, 2^m about 1 / cos(latitude).
//             Around either pole, where parallels are strongly curved: squares of 2^-k degrees in the plane
//             of the azimuthal equidistant projection
//   inside    biquadratic between the exact coordinates of 3 x 3 places: corners, middles of the sides,
//             centre. Cells side by side agree on their common side
//   checked   against exact coordinates at four places a quarter in from the sides, where a smooth function
//             is about furthest from its interpolation. A cell that is off there by more than kChecked
//             pixels, or not finite, is not interpolated: its places are asked exactly
//   outside   a box of degrees around the raster nothing is asked: u is NaN
//   k         chosen once a raster, so that a cell is at most 64 pixels high and the one in the middle passes
//
// So the result is a function of the place alone, never of thread or order, and within kBound pixels of the
// exact one. It jumps by no more than that between cells of different rows or kinds.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

namespace carat {

// Around a raster, in degrees; longitudes from that of its middle, -180 to 180.
struct DegreeBox {
    double middle = 0, west = -180, south = -90, east = 180, north = 90;

    bool contains(double lat, double lon) const {
        double d = lon - middle;
        d += d < -180 ? 360 : d > 180 ? -360 : 0;
        return d >= west && d <= east && lat >= south && lat <= north;
    }
};

// Thread-safe: every thread keeps the last cells it has used.
class PixelCells {
  public:
    // Latitudes and longitudes in degrees to pixel coordinates, which may be non-finite.
    using Exact = std::function<void(std::span<const double> lat, std::span<const double> lon,
                                     std::span<double> u, std::span<double> v)>;
    static constexpr double kBound = 1e-3;
    static constexpr double kChecked = kBound / 4;  // what lies between the places checked has the rest

    PixelCells() = default;  // all exact
    // lat, lon: a place in the middle of the raster; pixel: degrees of latitude that a pixel there spans.
    PixelCells(double lat, double lon, double pixel, const DegreeBox& box, const Exact& exact);

    void map(std::span<const double> lat, std::span<const double> lon, std::span<double> u,
             std::span<double> v, const Exact& exact) const;

  private:
    struct Key;
    struct Cell;
    double columns_per_degree(int chart, std::int64_t row) const;
    Cell make(const Key& key, const Exact& exact) const;
    const Cell& find(const Key& key, const Exact& exact) const;
    static void map_exactly(std::span<const std::size_t> which, std::span<const double> lat,
                            std::span<const double> lon, std::span<double> u, std::span<double> v,
                            const Exact& exact);

    std::uint64_t id_ = 0;        // of this raster, for the threads' cells
    double rows_per_degree_ = 0;  // 0: no cells
    DegreeBox box_;
};

}  // namespace carat
