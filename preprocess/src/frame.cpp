#include "frame.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr double kSlack = 1e-6;      // pixels a place may lie outside by rounding
constexpr double kPoleSlack = 0.01;  // rows a global raster may miss its pole by
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

std::array<double, 6> inverted(const std::array<double, 6>& g, const std::string& file) {
    const double det = g[1] * g[5] - g[2] * g[4];
    const double size = (std::abs(g[1]) + std::abs(g[2])) * (std::abs(g[4]) + std::abs(g[5]));
    bool finite = true;
    for (const double x : g) finite = finite && std::isfinite(x);
    if (!finite || !(std::abs(det) > 1e-12 * size) || !std::isfinite(1 / det))
        throw Error(ErrorCode::usage, file + ": its geotransform is degenerate");
    if (g[2] == 0 && g[4] == 0) return {-g[0] / g[1], 1 / g[1], 0, -g[3] / g[5], 0, 1 / g[5]};
    return {(g[2] * g[3] - g[0] * g[5]) / det,  g[5] / det,  -g[2] / det,
            (-g[1] * g[3] + g[0] * g[4]) / det, -g[4] / det, g[1] / det};
}

double distance(const Vec3& a, const Vec3& b) {
    const double x = a[0] - b[0], y = a[1] - b[1], z = a[2] - b[2];
    return std::sqrt(x * x + y * y + z * z);
}

}  // namespace

Frame::Frame(std::shared_ptr<const Crs> crs, const std::array<double, 6>& transform, std::int64_t width,
             std::int64_t height, const std::string& file)
    : crs_(std::move(crs)),
      transform_(transform),
      inverse_(inverted(transform, file)),
      width_(width),
      height_(height),
      axis_aligned_(transform[2] == 0 && transform[4] == 0) {
    find_wrap();
    if (crs_->is_costly()) find_cells();
}

void Frame::find_wrap() {
    const double turn = crs_->turn();
    if (turn == 0) return;
    const auto w = static_cast<double>(width_), h = static_cast<double>(height_);
    const double edge = transform_[0] + std::min(0.0, w * transform_[1]) - kSlack * std::abs(transform_[1]);
    const double centre = transform_[0] + w / 2 * transform_[1] + h / 2 * transform_[2];
    west_ = axis_aligned_ ? edge : centre - turn / 2;
    if (!axis_aligned_) return;
    find_period();
    if (period_ > 0) find_poles();
}

void Frame::find_cells() {
    const double u = static_cast<double>(width_) / 2, v = static_cast<double>(height_) / 2;
    const std::optional<Vec3> middle = normal(u, v), right = normal(u + 1, v), below = normal(u, v + 1);
    if (!middle || !right || !below) return;
    double lat = 0, lon = 0;
    to_degrees({&*middle, 1}, {&lat, 1}, {&lon, 1});
    const double pixel = std::min(distance(*middle, *right), distance(*middle, *below));
    cells_ = PixelCells(lat, lon, pixel * 180 / std::numbers::pi, box(lon),
                        [this](auto... spans) { to_unbounded_pixels(spans...); });
}

// From a net of places, with its widest mesh as margin; everything where the raster comes near a pole or goes
// round, or the CRS lacks a place.
DegreeBox Frame::box(double middle) const {
    constexpr int kNet = 16;
    constexpr double kNearPole = 88, kRound = 300;
    std::array<std::array<double, 2>, (kNet + 1) * (kNet + 1)> net{};  // latitude, longitude from the middle
    DegreeBox out{middle, 180, 90, -180, -90};
    double mesh_lat = 0, mesh_lon = 0;
    for (std::size_t k = 0; k < net.size(); ++k) {
        const auto n = normal(static_cast<double>(width_) * static_cast<double>(k % (kNet + 1)) / kNet,
                              static_cast<double>(height_) * static_cast<double>(k / (kNet + 1)) / kNet);
        if (!n) return {};
        auto& [lat, lon] = net[k];
        to_degrees({&*n, 1}, {&lat, 1}, {&lon, 1});
        lon = std::remainder(lon - middle, 360);
        out = {middle, std::min(out.west, lon), std::min(out.south, lat), std::max(out.east, lon),
               std::max(out.north, lat)};
        const auto compare = [&](std::size_t other) {
            mesh_lat = std::max(mesh_lat, std::abs(lat - net[other][0]));
            mesh_lon = std::max(mesh_lon, std::abs(lon - net[other][1]));
        };
        if (k % (kNet + 1) > 0) compare(k - 1);
        if (k > kNet) compare(k - kNet - 1);
    }
    out = {middle, out.west - mesh_lon, out.south - mesh_lat, out.east + mesh_lon, out.north + mesh_lat};
    if (std::max(out.north, -out.south) > kNearPole || out.east - out.west > kRound || out.east > 180 ||
        out.west < -180)
        return {};
    return out;
}

void Frame::find_period() {
    const double step = std::abs(transform_[1]);
    const double columns = std::round(crs_->turn() / step);
    if (columns < 1 || columns > static_cast<double>(width_)) return;
    if (std::abs(columns * step - crs_->turn()) <= kPoleSlack * step)
        period_ = static_cast<std::int64_t>(columns);
}

void Frame::find_poles() {
    if (height_ < 3) return;
    const double step = transform_[5];
    const double pole = step < 0 ? crs_->turn() / 4 : -crs_->turn() / 4;  // beyond row 0
    const double first = transform_[3] + step / 2;
    const double last = first + static_cast<double>(height_ - 1) * step;
    const auto end = [&](double rows, std::int64_t outer, std::int64_t inwards) -> PoleEnd {
        if (std::abs(rows) <= kPoleSlack) return {true, outer + inwards, 1, outer};
        if (rows > 0 && rows <= 0.5 + kPoleSlack) return {true, outer, rows, outer};
        return {};
    };
    top_ = end((pole - first) / -step, 0, 1);
    bottom_ = end((-pole - last) / step, height_ - 1, -1);
}

void Frame::to_unbounded_pixels(std::span<const double> lat, std::span<const double> lon, std::span<double> u,
                                std::span<double> v) const {
    if (crs_->is_plain()) {
        std::copy(lon.begin(), lon.end(), u.begin());
        std::copy(lat.begin(), lat.end(), v.begin());
    } else {
        crs_->forward(lat, lon, u, v);
    }
    const double turn = crs_->turn();
    if (turn > 0)
        for (double& x : u) x -= turn * std::floor((x - west_) / turn);
    if (axis_aligned_) {
        for (std::size_t i = 0; i < u.size(); ++i) {
            u[i] = (u[i] - transform_[0]) * inverse_[1];
            v[i] = (v[i] - transform_[3]) * inverse_[5];
        }
        return;
    }
    for (std::size_t i = 0; i < u.size(); ++i) {
        const double x = u[i] - transform_[0], y = v[i] - transform_[3];
        u[i] = x * inverse_[1] + y * inverse_[2];
        v[i] = x * inverse_[4] + y * inverse_[5];
    }
}

void Frame::to_pixels(std::span<const double> lat, std::span<const double> lon, std::span<double> u,
                      std::span<double> v) const {
    if (cells_)
        cells_->map(lat, lon, u, v, [this](auto... spans) { to_unbounded_pixels(spans...); });
    else
        to_unbounded_pixels(lat, lon, u, v);
    const auto w = static_cast<double>(width_), h = static_cast<double>(height_);
    const double left = period_ > 0 ? -1 : -kSlack, right = period_ > 0 ? w + 1 : w + kSlack;
    const double low = top_.reached ? -kPoleSlack : -kSlack;
    const double high = h + (bottom_.reached ? kPoleSlack : kSlack);
    for (std::size_t i = 0; i < u.size(); ++i) {
        const bool inside = u[i] >= left && u[i] <= right && v[i] >= low && v[i] <= high;
        u[i] = inside ? (period_ > 0 ? u[i] : std::min(std::max(u[i], 0.0), w)) : kNaN;
        v[i] = std::min(std::max(v[i], 0.0), h);
    }
}

std::optional<Vec3> Frame::normal(double u, double v) const {
    return crs_->normal(transform_[0] + u * transform_[1] + v * transform_[2],
                        transform_[3] + u * transform_[4] + v * transform_[5]);
}

std::optional<double> Frame::spacing(const Ellipsoid& body, double u, double v) const {
    const auto place = [&](double du, double dv) { return normal(u + du, v + dv); };
    const std::optional<Vec3> west = place(-0.5, 0), east = place(0.5, 0), north = place(0, -0.5),
                              south = place(0, 0.5);
    if (!west || !east || !north || !south) return std::nullopt;
    const double dx = distance(body.position(*west, 0), body.position(*east, 0));
    const double dy = distance(body.position(*north, 0), body.position(*south, 0));
    return std::max(std::sqrt(dx * dy), std::max(dx, dy) / 2);
}

void to_degrees(std::span<const Vec3> n, std::span<double> lat, std::span<double> lon) {
    constexpr double kDegrees = 180 / std::numbers::pi;
    for (std::size_t i = 0; i < n.size(); ++i) {
        const double x = n[i][0], y = n[i][1] + 0.0, z = n[i][2];  // + 0.0: no -0, so no longitude -180
        const double across = std::sqrt(x * x + y * y);
        lat[i] = std::atan2(z, across) * kDegrees;
        lon[i] = across == 0 ? 0.0 : std::atan2(y, x) * kDegrees;
    }
}

}  // namespace carat
