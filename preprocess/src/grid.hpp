// A grid of samples: one raster, or several rasters on one common grid, seen as one; read in tiles.
#pragma once

#include <atomic>
#include <cmath>
#include <cstdint>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <vector>

#include "cap.hpp"
#include "carat/preprocess/layer.hpp"
#include "frame.hpp"
#include "raster_file.hpp"
#include "tile_cache.hpp"

namespace carat {

// Where a file's samples lie in a grid.
struct GridPart {
    const RasterFile* file = nullptr;
    std::int64_t x = 0, y = 0;
};

// Over how many samples a grid fades into what lies below it; 0: not at all.
struct Feather {
    double holes = 0;  // at holes and at the edges of files within the grid, 0 to Grid::kMaxFeather
    double edges = 0;  // at the outer edges of the grid, any width
};

// Which samples of a region are there.
struct Coverage {
    double spacing = 0;  // metres, finest where samples are valid; +infinity if none is
    bool full = false;   // the whole region is certainly covered by valid samples
};

// Thread-safe once made.
class Grid {
  public:
    // Parts in priority order; all have the same type, scale and offset. Reads everything that may contain
    // holes, in parallel; or, if lazy, each tile when its coverage is asked for, and counts no samples. `key`
    // is unique among the grids of a cache.
    Grid(Frame frame, std::vector<GridPart> parts, const Ellipsoid& body, const Feather& feather,
         TileCache& cache, std::uint64_t key, bool lazy);
    static constexpr double kMaxFeather = 64;

    const Frame& frame() const { return frame_; }
    SampleType type() const { return parts_.front().file->header().type; }
    double scale() const { return parts_.front().file->header().scale; }
    double offset() const { return parts_.front().file->header().offset; }
    const Cap& cap() const { return cap_; }
    std::uint64_t samples() const { return samples_; }
    std::uint64_t valid_samples() const { return valid_samples_; }
    // Tiles that files cover, and how many have been read so far, those read again counted again.
    std::uint64_t tiles() const;
    std::uint64_t tile_reads() const { return tile_reads_; }

    // Heights at places in degrees, and 1 or 0 for a hole. Throws Error(io).
    void sample(std::span<const double> lat, std::span<const double> lon, Resampling resampling,
                std::span<double> heights, std::span<std::uint8_t> valid) const;

    // Weights 0..1 at places (at most kChunk) that are valid, by the rule for feathers in source.hpp; 1
    // elsewhere.
    void weigh(std::span<const double> lat, std::span<const double> lon, std::span<const std::uint8_t> valid,
               std::span<double> weights) const;

    // Samples within the box, in pixel coordinates, that holds the given places, plus a margin. The places
    // (at most 16) are those of a region of less than about 6 degrees: its corners, the middles of its sides
    // and, last, its middle; cap contains the region.
    Coverage cover(std::span<const Vec3> places, const Cap& cap) const;

    // Sides of the tiles that samples are read in, multiples of 64.
    int tile_width() const { return tile_width_; }
    int tile_height() const { return tile_height_; }
    // The tile that contains sample (x, y) of the grid; distances of its pixels' corners to holes.
    TilePtr tile_at(std::int64_t x, std::int64_t y) const;
    TilePtr distances_at(std::int64_t x, std::int64_t y) const;
    double feather() const { return feather_.holes; }
    // Pixels around a place that its distance may depend on.
    int reach() const { return static_cast<int>(std::ceil(feather_.holes)) + 1; }
    bool lazy() const { return scanned_ != nullptr; }
    // True if some weight of a place in the window is below 1.
    bool fades(const PixelWindow& window) const;
    // Mean of the valid samples of the row that stands for a pole, in the samples' own unit; nothing if there
    // is none.
    // Worked out when first asked for.
    const std::optional<double>& top_mean() const { return top_mean_.of(*this, frame_.top()); }
    const std::optional<double>& bottom_mean() const { return bottom_mean_.of(*this, frame_.bottom()); }

  private:
    class PoleMean {
      public:
        const std::optional<double>& of(const Grid& grid, const PoleEnd& pole) const;

      private:
        mutable std::once_flag once_;
        mutable std::optional<double> mean_;
    };
    struct Box {
        double min_u, min_v, max_u, max_v;
    };
    struct TileIndex {
        std::int64_t x, y;
    };

    void choose_tiles();
    void index_parts();
    void find_cap();
    void scan(bool lazy);
    void scan_tile(TileIndex t, std::uint64_t& samples, std::uint64_t& valid) const;
    void need_cells(std::int64_t x0, std::int64_t x1, std::int64_t y0, std::int64_t y1) const;
    void find_spacings(const Ellipsoid& body);
    double tile_spacing(const Ellipsoid& body, TileIndex t) const;

    PixelWindow window_of(TileIndex t) const;
    std::span<const std::uint32_t> parts_of(TileIndex t) const;
    TilePtr load(TileIndex t) const;
    TilePtr tile(TileIndex t) const;
    TilePtr load_distances(TileIndex t) const;
    std::vector<std::uint8_t> validity(const PixelWindow& window) const;
    double from_edges(double u, double v) const;
    bool far_from_holes(const PixelWindow& window) const;
    bool certainly_full(TileIndex t) const;
    std::vector<std::uint8_t> covered_by_parts(const PixelWindow& window) const;

    Box box_of(std::span<const Vec3> places, const Cap& cap) const;
    Box polar_box(const Cap& cap) const;
    double turn_in_pixels() const;
    bool inside(const Box& box) const;
    Coverage cover_cells(std::int64_t x0, std::int64_t x1, std::int64_t y0, std::int64_t y1) const;

    Frame frame_;
    std::vector<GridPart> parts_;
    Feather feather_;
    TileCache& cache_;
    std::uint64_t key_;
    Cap cap_;

    int tile_width_ = 0, tile_height_ = 0;
    std::int64_t tiles_x_ = 0, tiles_y_ = 0;
    std::vector<std::uint32_t> part_start_, part_list_;  // parts that meet each tile, in priority order

    // Squares of 2^cell_bits_ samples: bit 0: some sample is valid, bit 1: all are. Empty: all samples are
    // valid.
    static constexpr std::uint8_t kSome = 1, kAll = 2;
    int cell_bits_ = 4;
    std::int64_t cells_x_ = 0, cells_y_ = 0;
    mutable std::vector<std::uint8_t> cells_;
    std::unique_ptr<std::once_flag[]> scanned_;  // tiles, if they are scanned when they are asked for
    std::vector<double> spacings_;               // by row of cells if rows are parallels, else by tile

    std::uint64_t samples_ = 0, valid_samples_ = 0;
    mutable std::atomic<std::uint64_t> tile_reads_{0};
    PoleMean top_mean_, bottom_mean_;
};

}  // namespace carat
