#include "pixel_cells.hpp"

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <limits>
#include <numbers>
#include <vector>

namespace carat {
namespace {

constexpr double kPixelsHigh = 64;
constexpr double kPolar = 60;  // degrees of latitude
constexpr double kRadians = std::numbers::pi / 180;
constexpr int kHalvings = 3;         // of cells that are not smooth enough
constexpr std::size_t kKept = 1024;  // cells a thread keeps

std::uint64_t next_id() {
    static std::atomic<std::uint64_t> last{0};
    return ++last;
}

std::int64_t floor_of(double x) { return static_cast<std::int64_t>(std::floor(x)); }

// Coordinates in degrees in which cells are squares.
enum Chart : int { kMiddle = 0, kNorth = 1, kSouth = 2 };
struct Place {
    int chart;
    double x, y;
};

Place place_of(double lat, double lon) {
    if (std::abs(lat) <= kPolar) return {kMiddle, lon, lat};
    const double from_pole = 90 - std::abs(lat), angle = lon * kRadians;
    return {lat > 0 ? kNorth : kSouth, from_pole * std::cos(angle), from_pole * std::sin(angle)};
}

void degrees_of(const Place& p, double& lat, double& lon) {
    lat = p.y;
    lon = p.x;
    if (p.chart == kMiddle) return;
    const double from_pole = std::hypot(p.x, p.y);
    lat = p.chart == kNorth ? 90 - from_pole : from_pole - 90;
    lon = std::atan2(p.y, p.x) / kRadians;
}

}  // namespace

struct PixelCells::Key {
    int chart = 0;
    std::int64_t row = 0, column = 0;
    bool operator==(const Key&) const = default;
};

struct PixelCells::Cell {
    std::uint64_t id = 0;
    Key key;
    bool smooth = false;
    std::array<double, 9> u{}, v{};  // at x, y = 0, 1/2, 1: rows of y

    // The parabola through f(0), f(1/2), f(1).
    static double parabola(double low, double middle, double high, double x) {
        return low + x * (high - low) + 4 * x * (1 - x) * (middle - 0.5 * (low + high));
    }
    static double between(const std::array<double, 9>& c, double x, double y) {
        return parabola(parabola(c[0], c[1], c[2], x), parabola(c[3], c[4], c[5], x),
                        parabola(c[6], c[7], c[8], x), y);
    }
};

PixelCells::PixelCells(double lat, double lon, double pixel, const DegreeBox& box, const Exact& exact)
    : id_(next_id()), box_(box) {
    if (!(std::abs(lat) <= 90 && std::abs(lon) <= 360 && pixel > 0 && std::isfinite(pixel))) return;
    const Place p = place_of(lat, lon);
    double rows = std::exp2(std::max(0.0, std::ceil(-std::log2(kPixelsHigh * pixel))));
    for (int k = 0; k <= kHalvings; ++k, rows *= 2) {
        rows_per_degree_ = rows;
        const std::int64_t row = floor_of(p.y * rows);
        const std::int64_t column = floor_of(p.x * columns_per_degree(p.chart, row));
        if (make({p.chart, row, column}, exact).smooth) return;
    }
    rows_per_degree_ = 0;
}

double PixelCells::columns_per_degree(int chart, std::int64_t row) const {
    if (chart != kMiddle) return rows_per_degree_;
    const double a = std::abs(static_cast<double>(row)), b = std::abs(static_cast<double>(row + 1));
    const double shrink = std::cos(std::min(a, b) / rows_per_degree_ * kRadians);
    return std::ldexp(rows_per_degree_, std::ilogb(shrink));
}

PixelCells::Cell PixelCells::make(const Key& key, const Exact& exact) const {
    Cell cell{id_, key, true, {}, {}};
    constexpr std::size_t kPlaces = 13;  // 3 x 3, then the four that are checked
    std::array<double, kPlaces> x{}, y{}, lat{}, lon{}, u{}, v{};
    for (std::size_t k = 0; k < 9; ++k) {
        x[k] = 0.5 * static_cast<double>(k % 3);
        y[k] = 0.5 * static_cast<double>(k / 3);
    }
    for (std::size_t k = 0; k < 4; ++k) {
        x[9 + k] = k % 2 == 0 ? 0.25 : 0.75;
        y[9 + k] = k < 2 ? 0.25 : 0.75;
    }
    const double columns = columns_per_degree(key.chart, key.row);
    for (std::size_t k = 0; k < kPlaces; ++k)
        degrees_of({key.chart, (static_cast<double>(key.column) + x[k]) / columns,
                    (static_cast<double>(key.row) + y[k]) / rows_per_degree_},
                   lat[k], lon[k]);
    exact(lat, lon, u, v);
    std::copy_n(u.begin(), 9, cell.u.begin());
    std::copy_n(v.begin(), 9, cell.v.begin());
    for (std::size_t k = 9; k < kPlaces; ++k) {
        const double off =
            std::hypot(u[k] - Cell::between(cell.u, x[k], y[k]), v[k] - Cell::between(cell.v, x[k], y[k]));
        cell.smooth = cell.smooth && off <= kChecked;  // not if it is NaN
    }
    return cell;
}

const PixelCells::Cell& PixelCells::find(const Key& key, const Exact& exact) const {
    thread_local std::vector<Cell> kept(kKept);
    const std::uint64_t mixed = (static_cast<std::uint64_t>(key.row) * 0x9E3779B97F4A7C15u) ^
                                (static_cast<std::uint64_t>(key.column) * 0xC2B2AE3D27D4EB4Fu) ^
                                (id_ * 0x165667B19E3779F9u);
    Cell& cell = kept[(mixed >> 32) % kKept];
    if (cell.id != id_ || cell.key != key) cell = make(key, exact);
    return cell;
}

void PixelCells::map(std::span<const double> lat, std::span<const double> lon, std::span<double> u,
                     std::span<double> v, const Exact& exact) const {
    thread_local std::vector<std::size_t> left;
    left.clear();
    const Cell* cell = nullptr;  // in this thread's list until find() is called again
    double columns = 0;
    int chart = -1;
    std::int64_t row = 0;
    for (std::size_t i = 0; i < lat.size(); ++i) {
        if (!box_.contains(lat[i], lon[i])) {
            u[i] = std::numeric_limits<double>::quiet_NaN();
            v[i] = 0;
            continue;
        }
        if (rows_per_degree_ == 0) {
            left.push_back(i);
            continue;
        }
        const Place p = place_of(lat[i], lon[i]);
        const double y = p.y * rows_per_degree_;
        if (const std::int64_t r = floor_of(y); r != row || p.chart != chart) {
            row = r;
            chart = p.chart;
            columns = columns_per_degree(chart, row);
        }
        const double x = p.x * columns;
        const Key key{chart, row, floor_of(x)};
        if (cell == nullptr || cell->key != key) cell = &find(key, exact);
        if (!cell->smooth) {
            left.push_back(i);
            continue;
        }
        const double fx = x - static_cast<double>(key.column), fy = y - static_cast<double>(key.row);
        u[i] = Cell::between(cell->u, fx, fy);
        v[i] = Cell::between(cell->v, fx, fy);
    }
    map_exactly(left, lat, lon, u, v, exact);
}

void PixelCells::map_exactly(std::span<const std::size_t> which, std::span<const double> lat,
                             std::span<const double> lon, std::span<double> u, std::span<double> v,
                             const Exact& exact) {
    if (which.empty()) return;
    const std::size_t n = which.size();
    std::vector<double> some(4 * n);
    const std::span<double> la(some.data(), n), lo(some.data() + n, n), a(some.data() + 2 * n, n),
        b(some.data() + 3 * n, n);
    for (std::size_t k = 0; k < n; ++k) {
        la[k] = lat[which[k]];
        lo[k] = lon[which[k]];
    }
    exact(la, lo, a, b);
    for (std::size_t k = 0; k < n; ++k) {
        u[which[k]] = a[k];
        v[which[k]] = b[k];
    }
}

}  // namespace carat
