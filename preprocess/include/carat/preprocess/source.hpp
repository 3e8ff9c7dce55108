// Source heights: layers of rasters in priority order, then a base height.
//
//   place     a geodetic normal n of the body (globe: n-vector). Earth: geodetic latitude and longitude of
//             WGS 84; rasters on another datum go through PROJ. Other bodies: a raster's own geodetic
//             latitude and longitude are the body's (see LatitudeKind). Where PROJ is asked, pixel
//             coordinates are interpolated between its own, at most 0.001 pixels off (PixelCells). A CRS of
//             another body (semi-axis off by more than 1 %) is an Error(usage).
//   samples   pixel-is-area: a sample lies at the centre of its pixel; a raster is valid to the outer edges
//             of its outer pixels (and 1e-6 pixel of rounding), where the border samples go on outwards.
//             Height = offset + scale * raw, in the band's unit (m, ft, US survey ft, km, cm; others are
//             taken as metres, with a warning).
//   holes     NODATA (tag, mask band, option), NaN, +-infinity, heights outside the valid range. Integer
//             extremes without a NODATA tag are values.
//   kernel    nearest    the sample whose pixel contains the place (ties: to the greater row, column).
//             bilinear   the four samples around; holes are left out and the other weights renormalised;
//                        if the *nearest* sample is a hole, the place is a hole.
//             cubic      Catmull-Rom on 4 x 4 samples; if one that carries weight is a hole: bilinear.
//   wrap      a raster of 360 degrees of longitude wraps round: no seam. If its rows reach a pole, the pole
//             is one sample, the mean of the valid samples of the last row (of the row at the pole itself if
//             one is centred there), and heights between that row and the pole are linear in latitude:
//             continuous at the pole.
//   order     the first layer, and in it the first raster, that has no hole at the place gives the height.
//             Consecutive rasters of a layer on a common grid (equal CRS, type and pixel size, offset by
//             whole pixels) are one raster: interpolation sees no border between them. At last the base
//             height, which is in the datum of the last layer (its geoid, if any, is added).
//   feather   where a layer has a height, its weight is smoothstep(min(D / F, E / G)). D is the distance in
//             samples to the nearest pixel that is a hole or outside the raster: exact at corners of pixels,
//             between them bilinear; E that to the outer edges of the raster (or of the common grid). By
//             default F = 4 samples and G a sixteenth of the shorter side, 16 to 64 samples: holes stay
//             small, and borders above a much coarser layer are no cliffs. Weights w1, w2, ... of the layers
//             that have a height blend to (w1 h1 + (1-w1) w2 h2 + (1-w1)(1-w2) w3 h3 + ...) / (sum of the
//             coefficients): no step where a layer ends above another, no change where nothing lies below
//             (the base height is never blended in). Rasters of a layer without a common grid blend alike.
//   spacing   max(sqrt(dx dy), max(dx, dy) / 2) metres: a polar row of 7 m by 9 km is not a 7 m source.
//
// The height is a pure function of n, the files and the options: never of thread, batch, cache size or call
// order.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"
#include "carat/globe/sphere.hpp"
#include "carat/preprocess/layer.hpp"

namespace carat {

inline constexpr std::int8_t kBaseLayer = -1;
inline constexpr std::size_t kMaxLayers = 127;

// How the files of a stack are opened.
struct SourceOpening {
    // The one layer that is looked through for holes at once; the others are, tile by tile, where
    // coverage is asked for, and their samples are not counted (LayerInfo::samples is 0). Default: all.
    std::optional<std::size_t> fresh;
    bool hash_others = true;  // false: FileInfo::hash of the others is 0
};

// Thread-safe after construction, all const functions.
class SourceStack {
  public:
    // Opens every file, reads those that may contain holes once (in parallel), and hashes their contents.
    // cache_bytes bounds the decoded blocks kept in memory: three quarters ours (at least a block in each of
    // 16 shards), one quarter GDAL's block cache, which is lowered to that (not below 16 MiB) for the
    // process.
    //
    // Throws Error naming the file: io (missing, unreadable, truncated), unsupported (no bands, complex
    // numbers), usage (no georeference, degenerate geotransform, other body, bad option), limit (> 127
    // layers).
    SourceStack(const std::vector<LayerOptions>& layers, const Ellipsoid& body, double base_height,
                std::size_t cache_bytes, const SourceOpening& opening = {});
    ~SourceStack();
    SourceStack(SourceStack&&) noexcept;
    SourceStack& operator=(SourceStack&&) noexcept;

    struct Value {
        double height = 0;  // metres
        int layer = kBaseLayer;
        double weight = 1;  // of that layer in the height; 1 outside feathered zones
    };
    // Height at a unit geodetic normal. Throws Error(io) if a block cannot be read.
    Value sample(const Vec3& n) const;
    // The same values for many places: much faster, fastest when they lie close together. The three spans
    // have the same length; layer may be empty.
    void sample(std::span<const Vec3> n, std::span<double> heights, std::span<std::int8_t> layer) const;

    // The same at lattice points. (The place of a lattice point is worked out without rounding its normal to
    // unit length first: it may differ from that of direction(p) by rounding, a few 1e-14 degrees.)
    void sample(std::span<const LatticePoint> points, std::span<double> heights) const;
    // The same at the vertices of a half, in rows: for i = 0..cells, j = 0..i (side 0) or i..cells (side 1).
    // Fastest.
    void sample(const Half& half, int cells, std::span<double> heights) const;

    // Finest spacing, in metres, of the samples that win somewhere in the region of a diamond; +infinity
    // where only the base height applies. May look a little beyond the region (16 samples; an eighth of the
    // diamond where a finer layer lies beneath the border of a coarser one). Reads no file, but for layers
    // that are looked through when they are asked.
    double finest_spacing(DiamondId d) const;
    // False if a layer certainly gives no height anywhere in the region of a diamond. Reads no file.
    bool may_touch(std::size_t layer, DiamondId d) const;
    // False if a layer certainly has no say in finest_spacing() of a diamond and of those below it, children
    // of children included wherever they lie. Reads no file.
    bool may_reach(std::size_t layer, DiamondId d) const;
    // True if a layer has valid samples at a place or within 16 samples of it.
    bool is_near(std::size_t layer, const Vec3& n) const;
    // The first layer with valid samples at a place or within 16 samples of it, kBaseLayer if there is none;
    // as if the layer `without` were not there.
    int layer_near(const Vec3& n, std::optional<std::size_t> without = std::nullopt) const;

    // Tiles of samples, of all layers, and how many have been read so far, those read again counted again.
    struct Reads {
        std::uint64_t tiles = 0, reads = 0;
    };
    Reads reads() const;

    const std::vector<LayerInfo>& layers() const;
    // Plain sentences for the user: assumed CRS, unknown units, missing transformation grids.
    const std::vector<std::string>& warnings() const;
    const Ellipsoid& body() const;
    double base_height() const;

  private:
    friend class SourceSamples;
    struct State;
    std::unique_ptr<State> state_;
};

// The layers by the nominal spacing of their finest file (LayerInfo::spacing), finest first; equals keep
// their order. Opens every file, reads no samples. Throws as SourceStack does.
std::vector<LayerOptions> finest_first(const std::vector<LayerOptions>& layers, const Ellipsoid& body);

}  // namespace carat
