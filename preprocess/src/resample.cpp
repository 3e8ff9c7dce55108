// Grid::sample: the kernels. The rules stand in carat/preprocess/source.hpp.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "blend.hpp"
#include "grid.hpp"

namespace carat {
namespace {

// The sample row or column nearest to x, of the two around it: 0 or 1; ties to the greater.
int nearer(double fraction) { return fraction >= 0.5 ? 1 : 0; }

// Catmull-Rom weights of the samples at -1, 0, 1, 2.
std::array<double, 4> cubic_weights(double f) {
    const double f2 = f * f, f3 = f2 * f;
    return {-0.5 * f + f2 - 0.5 * f3, 1 - 2.5 * f2 + 1.5 * f3, 0.5 * f + 2 * f2 - 1.5 * f3,
            -0.5 * f2 + 0.5 * f3};
}

// Sum of weighted values; the weights sum to 1, and equal values give just that value. Weight 0 hides any
// value.
double weighted(const std::array<double, 4>& value, const std::array<double, 4>& weight) {
    const std::size_t most = weight[1] >= weight[2] ? 1 : 2;  // never 0
    double sum = 0;
    for (std::size_t i = 0; i < 4; ++i)
        if (weight[i] != 0) sum += weight[i] * (value[i] - value[most]);
    return value[most] + sum;
}

// Samples of one grid for one thread. Keeps the tiles around the last place alive.
template <class T>
class Sampler {
  public:
    explicit Sampler(const Grid& grid)
        : grid_(grid),
          frame_(grid.frame()),
          width_(frame_.width()),
          height_(frame_.height()),
          period_(frame_.period()),
          top_pole_row_(frame_.top().reached && frame_.top().row != 0 ? 0 : kNoRow),
          bottom_pole_row_(frame_.bottom().reached && frame_.bottom().row != height_ - 1 ? height_ - 1
                                                                                         : kNoRow) {}

    // Height in the samples' own unit at pixel coordinates inside the raster; false: hole.
    bool nearest(double u, double v, double& out) {
        const double y = v - 0.5;
        if (near_pole(y)) return polar(u, y, Resampling::nearest, out);
        return tap(static_cast<std::int64_t>(std::floor(u)),
                   std::min(static_cast<std::int64_t>(std::floor(v)), height_ - 1), out);
    }

    bool bilinear(double u, double v, double& out) {
        const double x = u - 0.5, y = v - 0.5;
        if (near_pole(y)) return polar(u, y, Resampling::bilinear, out);
        const double x0 = std::floor(x), y0 = std::floor(y);
        const auto column = static_cast<std::int64_t>(x0), row = static_cast<std::int64_t>(y0);
        const double fx = x - x0, fy = y - y0;
        if (tile_holds(column, row, 2)) {
            const T* p = samples_ + index(column, row);
            const double a = static_cast<double>(p[0]), b = static_cast<double>(p[1]);
            const double c = static_cast<double>(p[width_in_tile_]),
                         d = static_cast<double>(p[width_in_tile_ + 1]);
            const double above = a + fx * (b - a), below = c + fx * (d - c);
            out = above + fy * (below - above);
            return true;
        }
        return bilinear_by_taps(column, row, fx, fy, out);
    }

    bool cubic(double u, double v, double& out) {
        const double x = u - 0.5, y = v - 0.5;
        if (near_pole(y)) return polar(u, y, Resampling::cubic, out);
        const double x0 = std::floor(x), y0 = std::floor(y);
        const auto column = static_cast<std::int64_t>(x0), row = static_cast<std::int64_t>(y0);
        const double fx = x - x0, fy = y - y0;
        const std::array<double, 4> wx = cubic_weights(fx), wy = cubic_weights(fy);
        std::array<double, 4> line{};
        if (tile_holds(column - 1, row - 1, 4)) {
            for (std::int64_t j = 0; j < 4; ++j) {
                const T* p = samples_ + index(column - 1, row - 1 + j);
                line[static_cast<std::size_t>(j)] =
                    weighted({static_cast<double>(p[0]), static_cast<double>(p[1]), static_cast<double>(p[2]),
                              static_cast<double>(p[3])},
                             wx);
            }
        } else {
            for (std::size_t j = 0; j < 4; ++j)
                if (wy[j] != 0 && !cubic_line(column, row - 1 + static_cast<std::int64_t>(j), wx, line[j]))
                    return bilinear_by_taps(column, row, fx, fy, out);
        }
        out = weighted(line, wy);
        return true;
    }

  private:
    // The size x size samples from (column, row) lie in one tile, now the current one, and none is a hole.
    bool tile_holds(std::int64_t column, std::int64_t row, std::int64_t size) {
        if (!in_tile(column, row, size)) {
            if (column < 0 || row < 0 || column >= width_ || row >= height_) return false;
            move_to(column, row);
            if (!in_tile(column, row, size)) return false;
        }
        return whole_ || (!tile_->samples.empty() && all_valid(column, row, size));
    }
    bool all_valid(std::int64_t column, std::int64_t row, std::int64_t size) const {
        for (std::int64_t j = 0; j < size; ++j) {
            const std::uint8_t* p = tile_->valid.data() + index(column, row + j);
            for (std::int64_t i = 0; i < size; ++i)
                if (p[i] == 0) return false;
        }
        return true;
    }
    bool in_tile(std::int64_t column, std::int64_t row, std::int64_t size) const {
        return tile_ && column >= tile_->x && row >= tile_->y && column + size <= tile_->x + tile_->width &&
               row + size <= tile_->y + tile_->height;
    }
    std::size_t index(std::int64_t column, std::int64_t row) const {
        return static_cast<std::size_t>((row - tile_->y) * width_in_tile_ + (column - tile_->x));
    }

    void move_to(std::int64_t column, std::int64_t row) {
        if (in_tile(column, row, 1)) return;
        for (std::size_t k = 0; k < recent_.size(); ++k) {
            std::swap(tile_, recent_[k]);
            if (in_tile(column, row, 1)) return settle();
        }
        std::swap(tile_, recent_[oldest_]);
        oldest_ = (oldest_ + 1) % recent_.size();
        tile_ = grid_.tile_at(column, row);
        settle();
    }
    void settle() {
        samples_ = reinterpret_cast<const T*>(tile_->samples.data());
        width_in_tile_ = tile_->width;
        whole_ = !tile_->samples.empty() && tile_->valid.empty();
    }

    // One sample, with the wrap, the border and the poles; false: hole.
    bool tap(std::int64_t column, std::int64_t row, double& out) {
        if (row == top_pole_row_) return pole_sample(grid_.top_mean(), out);
        if (row == bottom_pole_row_) return pole_sample(grid_.bottom_mean(), out);
        if (row < 0 || row >= height_) over_the_pole(column, row);
        if (period_ > 0) {
            column %= period_;
            if (column < 0) column += period_;
        } else {
            column = std::clamp<std::int64_t>(column, 0, width_ - 1);
        }
        move_to(column, row);
        if (tile_->samples.empty()) return false;
        const std::size_t i = index(column, row);
        if (!tile_->valid.empty() && tile_->valid[i] == 0) return false;
        out = static_cast<double>(samples_[i]);
        return true;
    }

    static bool pole_sample(const std::optional<double>& mean, double& out) {
        if (mean) out = *mean;
        return mean.has_value();
    }

    // Rows beyond the raster: across the pole on the opposite meridian, or the border row again.
    void over_the_pole(std::int64_t& column, std::int64_t& row) const {
        if (row < 0 && frame_.top().reached) {
            row = 2 * frame_.top().mean_row - row - (frame_.top().row == 0 ? 1 : 0);
            column += period_ / 2;
        } else if (row >= height_ && frame_.bottom().reached) {
            row = 2 * (height_ - 1) - row + (frame_.bottom().row == height_ - 1 ? 1 : 0);
            column += period_ / 2;
        }
        row = std::clamp<std::int64_t>(row, 0, height_ - 1);
    }

    bool bilinear_by_taps(std::int64_t column, std::int64_t row, double fx, double fy, double& out) {
        std::array<double, 4> value{};
        std::array<bool, 4> there{};
        for (std::size_t k = 0; k < 4; ++k)
            there[k] = tap(column + static_cast<std::int64_t>(k & 1), row + static_cast<std::int64_t>(k >> 1),
                           value[k]);
        if (there[0] && there[1] && there[2] && there[3]) {
            const double above = value[0] + fx * (value[1] - value[0]);
            const double below = value[2] + fx * (value[3] - value[2]);
            out = above + fy * (below - above);
            return true;
        }
        if (!there[static_cast<std::size_t>(nearer(fx) + 2 * nearer(fy))]) return false;
        const std::array<double, 4> weight{(1 - fx) * (1 - fy), fx * (1 - fy), (1 - fx) * fy, fx * fy};
        double sum = 0, total = 0;
        for (std::size_t k = 0; k < 4; ++k) {
            if (!there[k]) continue;
            sum += weight[k] * value[k];
            total += weight[k];
        }
        out = sum / total;
        return true;
    }

    // Four samples of a row, weighted; false if one that carries weight is a hole.
    bool cubic_line(std::int64_t column, std::int64_t row, const std::array<double, 4>& weight, double& out) {
        std::array<double, 4> value{};
        for (std::size_t i = 0; i < 4; ++i)
            if (weight[i] != 0 && !tap(column - 1 + static_cast<std::int64_t>(i), row, value[i]))
                return false;
        out = weighted(value, weight);
        return true;
    }

    // --- between the last row and a pole ---

    bool near_pole(double y) const {
        return (frame_.top().reached && y < static_cast<double>(frame_.top().row)) ||
               (frame_.bottom().reached && y > static_cast<double>(frame_.bottom().row));
    }

    bool polar(double u, double y, Resampling resampling, double& out) {
        const bool at_top = frame_.top().reached && y < static_cast<double>(frame_.top().row);
        const PoleEnd& pole = at_top ? frame_.top() : frame_.bottom();
        const std::optional<double>& mean = at_top ? grid_.top_mean() : grid_.bottom_mean();
        const double t = std::min(1.0, std::abs(y - static_cast<double>(pole.row)) / pole.distance);
        double on_row = 0;
        const bool row_there = sample_row(u, pole.row, resampling, on_row);
        const bool pole_is_nearer = nearer(t) == 1;
        if (pole_is_nearer ? !mean.has_value() : !row_there) return false;
        if (resampling == Resampling::nearest || !mean || !row_there)
            out = pole_is_nearer ? *mean : on_row;
        else
            out = on_row + t * (*mean - on_row);
        return true;
    }

    bool sample_row(double u, std::int64_t row, Resampling resampling, double& out) {
        if (resampling == Resampling::nearest) return tap(static_cast<std::int64_t>(std::floor(u)), row, out);
        const double x = u - 0.5, x0 = std::floor(x);
        const auto column = static_cast<std::int64_t>(x0);
        if (resampling == Resampling::cubic && cubic_line(column, row, cubic_weights(x - x0), out))
            return true;
        return bilinear_by_taps(column, row, x - x0, 0, out);
    }

    const Grid& grid_;
    const Frame& frame_;
    const std::int64_t width_, height_, period_;
    static constexpr std::int64_t kNoRow = std::numeric_limits<std::int64_t>::min();
    const std::int64_t top_pole_row_, bottom_pole_row_;  // rows centred at a pole: one sample each
    TilePtr tile_;
    const T* samples_ = nullptr;
    std::int64_t width_in_tile_ = 0;
    bool whole_ = false;
    std::array<TilePtr, 3> recent_;
    std::size_t oldest_ = 0;
};

template <class T>
void sample_as(const Grid& grid, std::span<const double> lat, std::span<const double> lon,
               Resampling resampling, std::span<double> heights, std::span<std::uint8_t> valid) {
    Sampler<T> sampler(grid);
    const double scale = grid.scale(), offset = grid.offset();
    std::array<double, kChunk> u, v;
    for (std::size_t start = 0; start < lat.size(); start += kChunk) {
        const std::size_t n = std::min(kChunk, lat.size() - start);
        grid.frame().to_pixels(lat.subspan(start, n), lon.subspan(start, n), std::span(u).first(n),
                               std::span(v).first(n));
        for (std::size_t i = 0; i < n; ++i) {
            double value = 0;
            bool there = u[i] == u[i];
            if (there) switch (resampling) {
                    case Resampling::nearest:
                        there = sampler.nearest(u[i], v[i], value);
                        break;
                    case Resampling::bilinear:
                        there = sampler.bilinear(u[i], v[i], value);
                        break;
                    case Resampling::cubic:
                        there = sampler.cubic(u[i], v[i], value);
                        break;
                }
            valid[start + i] = there ? 1 : 0;
            heights[start + i] = offset + scale * value;
        }
    }
}

}  // namespace

void Grid::sample(std::span<const double> lat, std::span<const double> lon, Resampling resampling,
                  std::span<double> heights, std::span<std::uint8_t> valid) const {
    switch (type()) {
        case SampleType::int16:
            return sample_as<std::int16_t>(*this, lat, lon, resampling, heights, valid);
        case SampleType::int32:
            return sample_as<std::int32_t>(*this, lat, lon, resampling, heights, valid);
        case SampleType::float32:
            return sample_as<float>(*this, lat, lon, resampling, heights, valid);
        case SampleType::float64:
            return sample_as<double>(*this, lat, lon, resampling, heights, valid);
    }
}

}  // namespace carat
