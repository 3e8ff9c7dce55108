#include "grid.hpp"

#include <ogr_spatialref.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "carat/globe/error.hpp"

namespace carat::synth {
namespace {

struct TransformationDeleter {
    void operator()(OGRCoordinateTransformation* t) const { OGRCoordinateTransformation::DestroyCT(t); }
};
using Transformation = std::unique_ptr<OGRCoordinateTransformation, TransformationDeleter>;

enum class Way { to_degrees, from_degrees };

Transformation transformation(const Crs& crs, Way way) {
    OGRSpatialReference projected;
    if (projected.SetFromUserInput(crs.definition.c_str()) != OGRERR_NONE)
        throw Error(ErrorCode::io, crs.definition + ": PROJ does not know this coordinate system");
    projected.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRSpatialReference> geographic(projected.CloneGeogCS());
    geographic->SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const bool out = way == Way::to_degrees;
    Transformation t(OGRCreateCoordinateTransformation(out ? &projected : geographic.get(),
                                                       out ? geographic.get() : &projected));
    if (!t)
        throw Error(ErrorCode::io,
                    crs.definition + ": PROJ cannot transform between it and longitude and latitude");
    return t;
}

/// Turns coordinates of the system into degrees in place.
void make_degrees(const Crs& crs, std::vector<double>& x, std::vector<double>& y) {
    if (crs.geographic) return;
    if (!transformation(crs, Way::to_degrees)->Transform(static_cast<int>(x.size()), x.data(), y.data()))
        throw Error(ErrorCode::io, crs.definition + ": PROJ failed to transform a point");
}

}  // namespace

Crs epsg(int code, bool geographic) { return {"EPSG:" + std::to_string(code), geographic}; }
Crs moon_crs() { return {"+proj=longlat +R=1737400 +no_defs +type=crs", true}; }

std::vector<Vec3> Grid::normals(int first, int count) const {
    const auto size = static_cast<std::size_t>(width) * static_cast<std::size_t>(count);
    std::vector<double> x(size), y(size);
    std::size_t k = 0;
    for (int r = first; r < first + count; ++r)
        for (int c = 0; c < width; ++c, ++k) {
            x[k] = transform[0] + (c + 0.5) * transform[1] + (r + 0.5) * transform[2];
            y[k] = transform[3] + (c + 0.5) * transform[4] + (r + 0.5) * transform[5];
        }
    make_degrees(crs, x, y);
    std::vector<Vec3> n(size);
    for (k = 0; k < size; ++k) n[k] = direction(Geodetic{.latitude = y[k], .longitude = x[k]});
    return n;
}

Bounds Grid::bounds() const {
    constexpr int kSteps = 64;  // points along each side of the outline
    std::vector<double> x, y;
    const auto add = [&](double c, double r) {
        x.push_back(transform[0] + c * transform[1] + r * transform[2]);
        y.push_back(transform[3] + c * transform[4] + r * transform[5]);
    };
    const double w = width, h = height;
    for (int i = 0; i < kSteps; ++i) add(w * i / kSteps, 0);
    for (int i = 0; i < kSteps; ++i) add(w, h * i / kSteps);
    for (int i = 0; i < kSteps; ++i) add(w - w * i / kSteps, h);
    for (int i = 0; i <= kSteps; ++i) add(0, h - h * i / kSteps);
    make_degrees(crs, x, y);
    if (!crs.geographic)
        for (std::size_t i = 1; i < x.size(); ++i) x[i] += 360 * std::round((x[i - 1] - x[i]) / 360);
    Bounds b{*std::min_element(x.begin(), x.end()), *std::min_element(y.begin(), y.end()),
             *std::max_element(x.begin(), x.end()), *std::max_element(y.begin(), y.end())};
    if (std::abs(x.back() - x.front()) > 180)  // the outline goes round a pole
        b = b.north > 0 ? Bounds{-180, b.south, 180, 90} : Bounds{-180, -90, 180, b.north};
    return b;
}

std::array<int, 2> Grid::pixel(const Vec3& n) const {
    const Geodetic g = geodetic(n);
    const double turn = 360 / transform[1];
    double c = (g.longitude - transform[0]) / transform[1];
    c -= turn * std::floor(c / turn);
    const double r = (g.latitude - transform[3]) / transform[5];
    // A point on the outer edge belongs to the edge pixel: the poles lie on the edge of a global grid.
    const int column = std::min(static_cast<int>(std::floor(c)), c <= width ? width - 1 : width);
    const int row = std::min(static_cast<int>(std::floor(r)), r <= height ? height - 1 : height);
    if (column >= width || row < 0 || row >= height) return {-1, -1};
    return {column, row};
}

Grid degree_grid(double west, double north, double step, int width, int height) {
    return {width, height, {west, step, 0, north, 0, -step}, epsg(4326, true)};
}

Grid grid_around(const Crs& crs, const Geodetic& g, double spacing_m, int width) {
    double x = g.longitude, y = g.latitude;
    if (!transformation(crs, Way::from_degrees)->Transform(1, &x, &y))
        throw Error(ErrorCode::io, crs.definition + ": PROJ failed to transform a point");
    const auto snap = [&](double metres) { return std::round(metres / spacing_m) * spacing_m; };
    const double half = spacing_m * width / 2;
    return {width, width, {snap(x) - half, spacing_m, 0, snap(y) + half, 0, -spacing_m}, crs};
}

Grid utm_grid(const Geodetic& g, double spacing_m, int width) {
    const int zone = std::clamp(static_cast<int>(std::floor((g.longitude + 180) / 6)) + 1, 1, 60);
    return grid_around(epsg((g.latitude < 0 ? 32700 : 32600) + zone, false), g, spacing_m, width);
}

Grid global_grid(int width, const Crs& crs) {
    Grid g = degree_grid(-180, 90, 360.0 / width, width, width / 2);
    g.crs = crs;
    return g;
}

}  // namespace carat::synth
