// Where the pixels of a raster lie: an affine transform in some coordinate system, and the way to geodetic
// normals.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "carat/globe/ellipsoid.hpp"
#include "carat/synth/synth.hpp"

namespace carat::synth {

/// A coordinate system: what GDAL is told, and whether it is plain longitude and latitude in degrees.
struct Crs {
    std::string definition;  ///< "EPSG:n" or a PROJ string
    bool geographic;
};
Crs epsg(int code, bool geographic);
Crs moon_crs();

struct Grid {
    int width;
    int height;
    std::array<double, 6> transform;  ///< GDAL's: x = t0 + c t1 + r t2, y = t3 + c t4 + r t5
    Crs crs;

    /// Normals at the centres of the pixels of rows first .. first + count - 1, row by row. Thread-safe.
    /// Throws Error(io) when PROJ cannot transform.
    std::vector<Vec3> normals(int first, int count) const;
    /// Bounds of the outline; a grid that holds a pole spans all longitudes.
    Bounds bounds() const;
    /// Column and row of the pixel that holds n, of an unrotated geographic grid, wrapped in longitude; -1
    /// outside.
    std::array<int, 2> pixel(const Vec3& n) const;
};

/// North-up grid of degrees with its north-west corner at (west, north) and square pixels of `step` degrees.
Grid degree_grid(double west, double north, double step, int width, int height);
/// Square north-up grid of a projected system, `spacing_m` a pixel, centred within half a pixel of g.
/// Throws Error(io) when PROJ cannot transform.
Grid grid_around(const Crs& crs, const Geodetic& g, double spacing_m, int width);
/// The same in the UTM zone of g on WGS 84.
Grid utm_grid(const Geodetic& g, double spacing_m, int width);
/// The whole globe, `width` columns, width / 2 rows.
Grid global_grid(int width, const Crs& crs);

}  // namespace carat::synth
