// Grid: which samples of a region are there.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <numbers>

#include "grid.hpp"

namespace carat {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

}  // namespace

// Cells [x0, x1] x [y0, y1] are going to be looked at.
void Grid::need_cells(std::int64_t x0, std::int64_t x1, std::int64_t y0, std::int64_t y1) const {
    if (!scanned_) return;
    const std::int64_t side_x = tile_width_ >> cell_bits_, side_y = tile_height_ >> cell_bits_;
    for (std::int64_t y = y0 / side_y; y <= y1 / side_y; ++y)
        for (std::int64_t x = x0 / side_x; x <= x1 / side_x; ++x)
            std::call_once(scanned_[static_cast<std::size_t>(y * tiles_x_ + x)], [&] {
                std::uint64_t samples = 0, valid = 0;
                scan_tile({x, y}, samples, valid);
            });
}

double Grid::turn_in_pixels() const {
    return frame_.rows_are_parallels() ? frame_.crs().turn() / std::abs(frame_.transform()[1]) : 0;
}

// Around a pole longitude says nothing: all columns of the cap's latitudes.
Grid::Box Grid::polar_box(const Cap& cap) const {
    if (!frame_.rows_are_parallels()) return {-kInfinity, -kInfinity, kInfinity, kInfinity};
    const double middle = std::asin(std::clamp(cap.axis[2], -1.0, 1.0)), degree = std::numbers::pi / 180;
    const std::array<double, 2> lat{std::clamp((middle - cap.radius) / degree, -90.0, 90.0),
                                    std::clamp((middle + cap.radius) / degree, -90.0, 90.0)};
    const std::array<double, 2> lon{0, 0};
    std::array<double, 2> u{}, v{};
    frame_.to_unbounded_pixels(lat, lon, u, v);
    return {-kInfinity, std::min(v[0], v[1]) - 1, kInfinity, std::max(v[0], v[1]) + 1};
}

Grid::Box Grid::box_of(std::span<const Vec3> places, const Cap& cap) const {
    const bool polar = std::acos(std::min(1.0, std::abs(cap.axis[2]))) < 4 * cap.radius;
    if (polar && frame_.crs().turn() > 0) return polar_box(cap);
    constexpr std::size_t kMax = 16;
    std::array<double, kMax> lat{}, lon{}, u{}, v{};
    const std::size_t n = places.size();
    to_degrees(places, std::span(lat).first(n), std::span(lon).first(n));
    frame_.to_unbounded_pixels(std::span(lat).first(n), std::span(lon).first(n), std::span(u).first(n),
                               std::span(v).first(n));
    const double turn = turn_in_pixels();
    Box box{kInfinity, kInfinity, -kInfinity, -kInfinity};
    for (std::size_t i = 0; i < n; ++i) {
        if (!std::isfinite(u[i]) || !std::isfinite(v[i]))
            return {-kInfinity, -kInfinity, kInfinity, kInfinity};
        if (turn > 0)
            u[i] -= turn * std::round((u[i] - u[n - 1]) / turn);  // near the middle, the short way round
        box = {std::min(box.min_u, u[i]), std::min(box.min_v, v[i]), std::max(box.max_u, u[i]),
               std::max(box.max_v, v[i])};
    }
    const double du = 0.1 * (box.max_u - box.min_u) + 0.5, dv = 0.1 * (box.max_v - box.min_v) + 0.5;
    return {box.min_u - du, box.min_v - dv, box.max_u + du, box.max_v + dv};
}

bool Grid::inside(const Box& box) const {
    const auto w = static_cast<double>(frame_.width()), h = static_cast<double>(frame_.height());
    const bool columns = frame_.period() > 0 || (box.min_u >= 0 && box.max_u <= w);
    const bool rows = (frame_.top().reached || box.min_v >= 0) && (frame_.bottom().reached || box.max_v <= h);
    return columns && rows;
}

// Cells [x0, x1] x [y0, y1], all inside the grid.
Coverage Grid::cover_cells(std::int64_t x0, std::int64_t x1, std::int64_t y0, std::int64_t y1) const {
    need_cells(x0, x1, y0, y1);
    Coverage result{kInfinity, true};
    const bool by_row = frame_.rows_are_parallels();
    const int side_x = tile_width_ >> cell_bits_, side_y = tile_height_ >> cell_bits_;
    for (std::int64_t y = y0; y <= y1; ++y)
        for (std::int64_t x = x0; x <= x1; ++x) {
            const std::uint8_t cell =
                cells_.empty() ? kSome | kAll : cells_[static_cast<std::size_t>(y * cells_x_ + x)];
            result.full = result.full && (cell & kAll) != 0;
            if ((cell & kSome) != 0) {
                const auto i = static_cast<std::size_t>(by_row ? y : y / side_y * tiles_x_ + x / side_x);
                result.spacing = std::min(result.spacing, spacings_[i]);
            }
            if (by_row && !result.full && (cell & kSome) != 0) break;  // nothing more to learn from this row
        }
    return result;
}

Coverage Grid::cover(std::span<const Vec3> places, const Cap& cap) const {
    const Box box = box_of(places, cap);
    const auto w = static_cast<double>(frame_.width()), h = static_cast<double>(frame_.height());
    if (box.max_v < 0 || box.min_v > h) return {kInfinity, false};
    const auto cell = [&](double x, double limit) {
        return static_cast<std::int64_t>(std::clamp(x, 0.0, limit - 1)) >> cell_bits_;
    };
    const std::int64_t y0 = cell(box.min_v, h), y1 = cell(box.max_v, h);
    Coverage result{kInfinity, inside(box)};
    const auto add = [&](double u0, double u1) {
        if (u1 < 0 || u0 > w) return;
        const Coverage part = cover_cells(cell(u0, w), cell(u1, w), y0, y1);
        result.spacing = std::min(result.spacing, part.spacing);
        result.full = result.full && part.full;
    };
    const double turn = turn_in_pixels();
    if (turn == 0 || !(box.max_u - box.min_u < turn)) {
        add(turn > 0 ? 0 : box.min_u, turn > 0 ? w : box.max_u);
        return result;
    }
    for (int k = -1; k <= 1; ++k) add(box.min_u + k * turn, box.max_u + k * turn);
    return result;
}

}  // namespace carat
