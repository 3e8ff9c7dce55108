// Grid: distances to holes and the weights made of them.
#include <algorithm>
#include <cmath>
#include <limits>

#include "blend.hpp"
#include "grid.hpp"

namespace carat {
namespace {

// For each corner between two of `count` pixels of a row (out[i]: between i - 1 and i), its distance along
// the row to the nearest hole, at most `most`. out[0] is not set.
void row_distances(const std::uint8_t* valid, int count, int most, int* out) {
    int d = most;
    for (int i = 1; i < count; ++i) out[i] = d = valid[i - 1] != 0 ? std::min(d + 1, most) : 0;
    d = most;
    for (int i = count - 1; i > 0; --i) {
        d = valid[i] != 0 ? std::min(d + 1, most) : 0;
        out[i] = std::min(out[i], d);
    }
}

}  // namespace

// 1 for samples, 0 for holes and what lies outside; across 180 and the poles the raster goes on.
std::vector<std::uint8_t> Grid::validity(const PixelWindow& window) const {
    std::vector<std::uint8_t> valid(
        static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height), 0);
    TilePtr tile;
    for (int j = 0; j < window.height; ++j) {
        std::int64_t y = window.y + j;
        if ((y < 0 && !frame_.top().reached) || (y >= frame_.height() && !frame_.bottom().reached)) continue;
        y = std::clamp<std::int64_t>(y, 0, frame_.height() - 1);
        for (int i = 0; i < window.width; ++i) {
            std::int64_t x = window.x + i;
            if (frame_.period() > 0)
                x = (x % frame_.period() + frame_.period()) % frame_.period();
            else if (x < 0 || x >= frame_.width())
                continue;
            if (!tile || x < tile->x || y < tile->y || x >= tile->x + tile->width ||
                y >= tile->y + tile->height)
                tile = tile_at(x, y);
            if (tile->samples.empty()) continue;
            const auto k = static_cast<std::size_t>((y - tile->y) * tile->width + (x - tile->x));
            valid[static_cast<std::size_t>(j) * static_cast<std::size_t>(window.width) +
                  static_cast<std::size_t>(i)] = tile->valid.empty() ? 1 : tile->valid[k];
        }
    }
    return valid;
}

bool Grid::far_from_holes(const PixelWindow& window) const {
    const std::int64_t x1 = window.x + window.width - 1, y1 = window.y + window.height - 1;
    const auto outside = [](std::int64_t first, std::int64_t last, std::int64_t size) {
        return first < 0 || last >= size;
    };
    if (outside(window.x, x1, frame_.width()) && (frame_.period() == 0 || !cells_.empty())) return false;
    if (window.y < 0 && !frame_.top().reached) return false;
    if (y1 >= frame_.height() && !frame_.bottom().reached) return false;
    if (cells_.empty()) return true;
    const std::int64_t top = std::max<std::int64_t>(window.y, 0), bottom = std::min(y1, frame_.height() - 1);
    need_cells(window.x >> cell_bits_, x1 >> cell_bits_, top >> cell_bits_, bottom >> cell_bits_);
    for (std::int64_t y = top >> cell_bits_; y <= bottom >> cell_bits_; ++y)
        for (std::int64_t x = window.x >> cell_bits_; x <= x1 >> cell_bits_; ++x)
            if ((cells_[static_cast<std::size_t>(y * cells_x_ + x)] & kAll) == 0) return false;
    return true;
}

// For the upper left corner of each of a tile's pixels, the distance to the nearest pixel that is a hole, as
// floats, at most feather + 1; no samples: all are that far.
TilePtr Grid::load_distances(TileIndex t) const {
    const PixelWindow w = window_of(t);
    const int reach = this->reach();
    const PixelWindow around{w.x - reach, w.y - reach, w.width + 2 * reach, w.height + 2 * reach};
    auto tile = std::make_shared<Tile>(Tile{w.x, w.y, w.width, w.height, {}, {}});
    if (far_from_holes(around)) return tile;
    const std::vector<std::uint8_t> valid = validity(around);
    const auto row = [&](int y) {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(around.width);
    };
    std::vector<int> in_row(valid.size());
    for (int y = 0; y < around.height; ++y)
        row_distances(valid.data() + row(y), around.width, reach, in_row.data() + row(y));
    tile->samples.resize(static_cast<std::size_t>(w.width) * static_cast<std::size_t>(w.height) *
                         sizeof(float));
    auto* out = reinterpret_cast<float*>(tile->samples.data());
    for (int y = 0; y < w.height; ++y)
        for (int x = 0; x < w.width; ++x) {
            int nearest = reach * reach;
            for (int k = 0; k < reach; ++k)  // k whole rows of pixels between the corner and the row
                for (const int pixel_row : {y + reach + k, y + reach - 1 - k}) {
                    const int dx = in_row[row(pixel_row) + static_cast<std::size_t>(x + reach)];
                    nearest = std::min(nearest, dx * dx + k * k);
                }
            *out++ = std::min(std::sqrt(static_cast<float>(nearest)), static_cast<float>(feather_.holes + 1));
        }
    return tile;
}

TilePtr Grid::distances_at(std::int64_t x, std::int64_t y) const {
    const TileIndex t{x / tile_width_, y / tile_height_};
    const std::uint64_t index = static_cast<std::uint64_t>(t.y * tiles_x_ + t.x);
    constexpr std::uint64_t kDistances = std::uint64_t{1} << 39;
    return cache_.get((key_ << 40) | kDistances | index, [&] { return load_distances(t); });
}

// Distances for one thread, bilinear between corners of pixels; keeps the last tiles.
class DistanceSampler {
  public:
    explicit DistanceSampler(const Grid& grid) : grid_(grid), frame_(grid.frame()) {}

    double at(double u, double v) {
        const double u0 = std::floor(u), v0 = std::floor(v), fx = u - u0, fy = v - v0;
        const auto column = static_cast<std::int64_t>(u0), row = static_cast<std::int64_t>(v0);
        if (grid_.lazy() && inside_whole_tile(column, row)) return grid_.feather() + 1;
        const double above = tap(column, row) * (1 - fx) + tap(column + 1, row) * fx;
        const double below = tap(column, row + 1) * (1 - fx) + tap(column + 1, row + 1) * fx;
        return above * (1 - fy) + below * fy;
    }

  private:
    // All pixels that matter lie in a tile without holes: then its neighbours need not be read.
    bool inside_whole_tile(std::int64_t x, std::int64_t y) {
        const int reach = grid_.reach();
        if (x < 0 || y < 0 || x >= frame_.width() || y >= frame_.height()) return false;
        if (!samples_ || x < samples_->x || y < samples_->y || x >= samples_->x + samples_->width ||
            y >= samples_->y + samples_->height)
            samples_ = grid_.tile_at(x, y);
        const Tile& t = *samples_;
        return !t.samples.empty() && t.valid.empty() && x - reach >= t.x && y - reach >= t.y &&
               x + reach < t.x + t.width && y + reach < t.y + t.height;
    }
    // Corners on the outer edges touch what lies outside: 0.
    double tap(std::int64_t x, std::int64_t y) {
        if ((y < 0 && !frame_.top().reached) || (y >= frame_.height() && !frame_.bottom().reached)) return 0;
        y = std::clamp<std::int64_t>(y, 0, frame_.height() - 1);
        if (frame_.period() > 0)
            x = (x % frame_.period() + frame_.period()) % frame_.period();
        else if (x < 0 || x >= frame_.width())
            return 0;
        if (!holds(x, y)) {
            std::swap(tile_, last_);
            if (!holds(x, y)) tile_ = grid_.distances_at(x, y);
        }
        if (tile_->samples.empty()) return static_cast<float>(grid_.feather() + 1);
        const auto k = static_cast<std::size_t>((y - tile_->y) * tile_->width + (x - tile_->x));
        return static_cast<double>(reinterpret_cast<const float*>(tile_->samples.data())[k]);
    }
    bool holds(std::int64_t x, std::int64_t y) const {
        return tile_ && x >= tile_->x && y >= tile_->y && x < tile_->x + tile_->width &&
               y < tile_->y + tile_->height;
    }

    const Grid& grid_;
    const Frame& frame_;
    TilePtr tile_, last_;
    TilePtr samples_;
};

// Samples between a place and the nearest outer edge of the grid that is one: 180 and the poles are none.
double Grid::from_edges(double u, double v) const {
    constexpr double kNone = std::numeric_limits<double>::infinity();
    const auto w = static_cast<double>(frame_.width()), h = static_cast<double>(frame_.height());
    const double across = frame_.period() > 0 ? kNone : std::min(u, w - u);
    const double above = frame_.top().reached ? kNone : v, below = frame_.bottom().reached ? kNone : h - v;
    return std::min(across, std::min(above, below));
}

bool Grid::fades(const PixelWindow& window) const {
    if (feather_.holes > 0 && !distances_at(window.x, window.y)->samples.empty()) return true;
    const auto x = static_cast<double>(window.x), y = static_cast<double>(window.y);
    return std::min(from_edges(x, y), from_edges(x + window.width, y + window.height)) < feather_.edges;
}

void Grid::weigh(std::span<const double> lat, std::span<const double> lon,
                 std::span<const std::uint8_t> valid, std::span<double> weights) const {
    std::fill(weights.begin(), weights.end(), 1.0);
    if (feather_.holes == 0 && feather_.edges == 0) return;
    std::array<double, kChunk> u, v;
    frame_.to_pixels(lat, lon, std::span(u).first(lat.size()), std::span(v).first(lat.size()));
    DistanceSampler distances(*this);
    for (std::size_t i = 0; i < lat.size(); ++i) {
        if (valid[i] == 0) continue;
        const double of_holes = feather_.holes > 0 ? distances.at(u[i], v[i]) / feather_.holes : 1;
        const double of_edges = feather_.edges > 0 ? from_edges(u[i], v[i]) / feather_.edges : 1;
        const double t = std::clamp(std::min(of_holes, of_edges), 0.0, 1.0);
        weights[i] = t * t * (3 - 2 * t);
    }
}

}  // namespace carat
