#include "source_samples.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include "source_state.hpp"

namespace carat {
namespace {

constexpr int kBlockSide = 256;  // at most, in samples
constexpr int kBandRows = 1024;  // rows that are gone through column by column

void add_blocks(const Grid& grid, int layer, std::vector<SampleBlock>& out) {
    const std::int64_t width = grid.frame().width(), height = grid.frame().height();
    const std::int64_t step_x = std::min(kBlockSide, grid.tile_width()),
                       step_y = std::min(kBlockSide, grid.tile_height());
    // A block lies in one tile: the sides of tiles are multiples of 64 but not always of a block's.
    const auto next = [](std::int64_t at, std::int64_t step, std::int64_t tile, std::int64_t end) {
        return std::min({at + step, (at / tile + 1) * tile, end});
    };
    for (std::int64_t band = 0; band < height; band += kBandRows)
        for (std::int64_t x = 0, x1 = 0; x < width; x = x1) {
            x1 = next(x, step_x, grid.tile_width(), width);
            const std::int64_t end = std::min<std::int64_t>(band + kBandRows, height);
            for (std::int64_t y = band, y1 = 0; y < end; y = y1) {
                y1 = next(y, step_y, grid.tile_height(), end);
                out.push_back({layer, &grid, {x, y, static_cast<int>(x1 - x), static_cast<int>(y1 - y)}});
            }
        }
}

// Normals of the samples of a window, row by row; NaN where the CRS has no such place.
class RowNormals {
  public:
    RowNormals(const Frame& frame, const PixelWindow& window) : frame_(frame), window_(window) {
        by_columns_ = frame.crs().is_plain() && frame.transform()[2] == 0 && frame.transform()[4] == 0;
        if (!by_columns_) return;
        for (int i = 0; i < window.width; ++i) meridians_.push_back(direction(Geodetic{0, x(i, 0)}));
    }

    void operator()(int j, std::vector<Vec3>& out) {
        const auto count = static_cast<std::size_t>(window_.width);
        out.resize(count);
        if (by_columns_) {
            const Vec3 row = direction(Geodetic{std::clamp(y(0, j), -90.0, 90.0), 0});
            for (std::size_t i = 0; i < count; ++i)
                out[i] = {row[0] * meridians_[i][0], row[0] * meridians_[i][1], row[2]};
            return;
        }
        lon_.resize(count);
        lat_.resize(count);
        for (int i = 0; i < window_.width; ++i) {
            lon_[static_cast<std::size_t>(i)] = x(i, j);
            lat_[static_cast<std::size_t>(i)] = y(i, j);
        }
        frame_.crs().inverse(lon_, lat_);
        constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
        for (std::size_t i = 0; i < count; ++i)
            out[i] = std::isfinite(lon_[i]) && std::isfinite(lat_[i])
                         ? direction(Geodetic{std::clamp(lat_[i], -90.0, 90.0), lon_[i]})
                         : Vec3{kNaN, kNaN, kNaN};
    }

  private:
    // The CRS's coordinates of the middle of a pixel.
    double u(int i) const { return static_cast<double>(window_.x + i) + 0.5; }
    double v(int j) const { return static_cast<double>(window_.y + j) + 0.5; }
    double x(int i, int j) const {
        const auto& g = frame_.transform();
        return g[0] + u(i) * g[1] + v(j) * g[2];
    }
    double y(int i, int j) const {
        const auto& g = frame_.transform();
        return g[3] + u(i) * g[4] + v(j) * g[5];
    }

    const Frame& frame_;
    const PixelWindow& window_;
    bool by_columns_ = false;
    std::vector<Vec3> meridians_;
    std::vector<double> lon_, lat_;
};

// A sample in the grid's own unit.
double raw(const Tile& tile, SampleType type, std::size_t k) {
    const std::byte* p = tile.samples.data();
    switch (type) {
        case SampleType::int16:
            return static_cast<double>(reinterpret_cast<const std::int16_t*>(p)[k]);
        case SampleType::int32:
            return static_cast<double>(reinterpret_cast<const std::int32_t*>(p)[k]);
        case SampleType::float32:
            return static_cast<double>(reinterpret_cast<const float*>(p)[k]);
        case SampleType::float64:
            break;
    }
    return reinterpret_cast<const double*>(p)[k];
}

// The mean that stands for a row of samples at a pole itself; nothing for other rows.
const std::optional<double>* pole_mean(const Grid& grid, std::int64_t row) {
    const Frame& f = grid.frame();
    if (f.top().reached && f.top().row != 0 && row == 0) return &grid.top_mean();
    if (f.bottom().reached && f.bottom().row != f.height() - 1 && row == f.height() - 1)
        return &grid.bottom_mean();
    return nullptr;
}

}  // namespace

void BlockSamples::clear() {
    places.clear();
    heights.clear();
    blended.clear();
    hidden = 0;
}

SourceSamples::SourceSamples(const SourceStack& stack) : stack_(*stack.state_) {
    for (std::size_t k = 0; k < stack_.layers.size(); ++k)
        for (const auto& grid : stack_.layers[k]->grids()) add_blocks(*grid, static_cast<int>(k), blocks_);
}

// Reads one block.
class SourceSamples::Reader {
  public:
    Reader(const SourceStack::State& stack, const SampleBlock& block, BlockSamples& out)
        : stack_(stack), block_(block), grid_(*block.grid), out_(out) {}

    void read() {
        collect();
        if (normals_.empty()) return;
        if (const Geoid* geoid = stack_.layers[static_cast<std::size_t>(block_.layer)]->geoid())
            add_geoid(*geoid);
        find_others();
        const bool fades = !below_.empty() && grid_.fades(block_.window);
        const bool alone = above_.empty() && !fades;
        for (std::size_t start = 0; start < normals_.size(); start += kChunk) {
            const std::size_t count = std::min(kChunk, normals_.size() - start);
            if (alone)
                for (std::size_t i = start; i < start + count; ++i) add(i, heights_[i], false);
            else
                add_chunk(start, count, fades);
        }
    }

  private:
    struct Other {
        const Grid* grid;
        Resampling resampling;
    };

    void collect() {
        const PixelWindow& w = block_.window;
        const TilePtr tile = grid_.tile_at(w.x, w.y);
        if (tile->samples.empty()) return;
        RowNormals row_normals(grid_.frame(), w);
        std::vector<Vec3> row;
        for (int j = 0; j < w.height; ++j) {
            const std::optional<double>* mean = pole_mean(grid_, w.y + j);
            if (mean != nullptr && (w.x > 0 || !*mean)) continue;  // one sample for the whole row
            row_normals(j, row);
            const std::size_t first =
                static_cast<std::size_t>((w.y + j - tile->y) * tile->width + (w.x - tile->x));
            for (std::size_t i = 0; i < (mean != nullptr ? 1 : row.size()); ++i) {
                if (!tile->valid.empty() && tile->valid[first + i] == 0) continue;
                if (!std::isfinite(row[i][0])) continue;
                normals_.push_back(row[i]);
                heights_.push_back(grid_.offset() +
                                   grid_.scale() *
                                       (mean != nullptr ? **mean : raw(*tile, grid_.type(), first + i)));
            }
        }
    }

    // A place without a geoid height is a hole.
    void add_geoid(const Geoid& geoid) {
        std::vector<double> lat(normals_.size()), lon(normals_.size());
        std::vector<std::uint8_t> valid(normals_.size(), 1);
        to_degrees(normals_, lat, lon);
        geoid.add(lat, lon, heights_, valid);
        std::size_t left = 0;
        for (std::size_t i = 0; i < normals_.size(); ++i) {
            if (valid[i] == 0) continue;
            normals_[left] = normals_[i];
            heights_[left++] = heights_[i];
        }
        normals_.resize(left);
        heights_.resize(left);
    }

    // The grids that may have a height where the block lies, above and below its own.
    void find_others() {
        const Cap cap = cap_of(normals_);
        bool before = true;
        for (std::size_t k = 0; k < stack_.layers.size(); ++k)
            for (const auto& grid : stack_.layers[k]->grids()) {
                if (grid.get() == &grid_)
                    before = false;
                else if (meet(grid->cap(), cap))
                    (before ? above_ : below_).push_back({grid.get(), stack_.layers[k]->resampling()});
            }
    }

    void add_chunk(std::size_t start, std::size_t count, bool fades) {
        const std::span<const Vec3> n(normals_.data() + start, count);
        to_degrees(n, std::span(lat_).first(count), std::span(lon_).first(count));
        std::array<double, kChunk> covered{}, own{}, none_below{};
        std::fill_n(own.begin(), count, 1.0);
        for (const Other& other : above_) cover(other, count, covered);
        if (fades) {
            std::array<std::uint8_t, kChunk> valid;
            valid.fill(1);
            grid_.weigh(lat(count), lon(count), std::span(valid).first(count), std::span(own).first(count));
            if (std::any_of(own.begin(), own.begin() + static_cast<std::ptrdiff_t>(count),
                            [](double w) { return w < 1; })) {
                for (const Other& other : below_) cover(other, count, none_below);
            }
        }
        std::array<double, kChunk> blended;
        bool have_blended = false;
        for (std::size_t i = 0; i < count; ++i) {
            if (covered[i] == kClosed) {
                ++out_.hidden;
                continue;
            }
            const bool mixed = covered[i] > 0 || (own[i] < 1 && none_below[i] > 0);
            if (mixed && !have_blended) {
                stack_.sample_chunk(n, std::span(blended).first(count), {}, {});
                have_blended = true;
            }
            add(start + i, mixed ? blended[i] : heights_[start + i], mixed);
        }
    }

    // What another grid does at the places of a chunk: nothing, have a share, or hide what lies below it.
    static constexpr double kOpen = 0, kShare = 1, kClosed = 2;
    void cover(const Other& other, std::size_t count, std::array<double, kChunk>& covered) const {
        std::array<double, kChunk> heights, weights;
        std::array<std::uint8_t, kChunk> valid;
        const std::span<std::uint8_t> hit(valid.data(), count);
        other.grid->sample(lat(count), lon(count), other.resampling, std::span(heights).first(count), hit);
        other.grid->weigh(lat(count), lon(count), hit, std::span(weights).first(count));
        for (std::size_t i = 0; i < count; ++i)
            if (valid[i] != 0) covered[i] = std::max(covered[i], weights[i] == 1 ? kClosed : kShare);
    }

    std::span<const double> lat(std::size_t count) const { return {lat_.data(), count}; }
    std::span<const double> lon(std::size_t count) const { return {lon_.data(), count}; }

    void add(std::size_t i, double height, bool blended) {
        out_.places.push_back(lattice_position(normals_[i]));
        out_.heights.push_back(height);
        out_.blended.push_back(blended ? 1 : 0);
    }

    const SourceStack::State& stack_;
    const SampleBlock& block_;
    const Grid& grid_;
    BlockSamples& out_;
    std::vector<Vec3> normals_;
    std::vector<double> heights_;
    std::vector<Other> above_, below_;
    std::array<double, kChunk> lat_, lon_;
};

void SourceSamples::read(const SampleBlock& block, BlockSamples& out) const {
    out.clear();
    Reader(stack_, block, out).read();
}

}  // namespace carat
