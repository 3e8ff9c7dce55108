#include "carat/preprocess/source.hpp"

#include <gdal.h>

#include <algorithm>
#include <array>
#include <limits>

#include "blend.hpp"
#include "cap.hpp"
#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/patch.hpp"
#include "frame.hpp"
#include "gdal_errors.hpp"
#include "half_degrees.hpp"
#include "source_state.hpp"

namespace carat {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr int kSmallHalfLevel = 10;  // halves from this level on span less than 5 degrees
constexpr int kMoreLevels = 6;       // halves an eighth as long show where a higher layer ends

// Corners, middles of the sides and, last, the middle of a half.
std::array<Vec3, 7> outline(const Half& half) {
    const HalfFrame frame = half_frame(half, 4);
    const bool lower = half.side == 0;
    const auto at = [&](int i, int j) { return direction(lower ? frame.vertex(i, j) : frame.vertex(j, i)); };
    return {at(0, 0), at(4, 0), at(4, 4), at(2, 0), at(4, 2), at(2, 2), at(3, 1)};
}

Cap cap_of_half(const Half& half) {
    const NormalCone cone = normal_cone(half);
    return {cone.axis, std::atan2(cone.sin_angle, cone.cos_angle)};
}

// GDAL's block cache serves files whose blocks straddle our tiles (strips); it is one for the whole process.
void limit_gdal_cache(std::size_t bytes) {
    constexpr std::size_t kLeast = std::size_t{16} << 20;
    const auto limit = static_cast<GIntBig>(std::max(bytes, kLeast));
    if (GDALGetCacheMax64() > limit) GDALSetCacheMax64(limit);
}

}  // namespace

Resampling parse_resampling(const std::string& text) {
    for (const Resampling r : {Resampling::nearest, Resampling::bilinear, Resampling::cubic})
        if (text == to_string(r)) return r;
    throw Error(ErrorCode::usage, "resampling '" + text + "' is none of nearest, bilinear, cubic");
}

const char* to_string(Resampling r) {
    switch (r) {
        case Resampling::nearest:
            return "nearest";
        case Resampling::bilinear:
            return "bilinear";
        case Resampling::cubic:
            break;
    }
    return "cubic";
}

std::vector<LayerOptions> finest_first(const std::vector<LayerOptions>& layers, const Ellipsoid& body) {
    initialise_gdal();
    HandlePool handles;
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < layers.size(); ++k)
        order.emplace_back(nominal_spacing(layers[k], body, handles), k);
    std::sort(order.begin(), order.end());
    std::vector<LayerOptions> out;
    for (const auto& [spacing, k] : order) out.push_back(layers[k]);
    return out;
}

SourceStack::SourceStack(const std::vector<LayerOptions>& layers, const Ellipsoid& body, double base_height,
                         std::size_t cache_bytes, const SourceOpening& opening)
    : state_(std::make_unique<State>(body, base_height, cache_bytes)) {
    if (layers.size() > kMaxLayers)
        throw Error(ErrorCode::limit,
                    std::to_string(layers.size()) + " layers, more than " + std::to_string(kMaxLayers));
    if (!std::isfinite(base_height)) throw Error(ErrorCode::usage, "the base height is not finite");
    initialise_gdal();
    limit_gdal_cache(cache_bytes / 4);
    State& s = *state_;
    for (const LayerOptions& options : layers) {
        const std::uint64_t key = s.layers.size() * kKeysPerLayer;
        const bool lazy = opening.fresh && *opening.fresh != s.layers.size();
        s.layers.push_back(std::make_unique<SourceLayer>(options, body, s.handles, s.cache, key, s.warnings,
                                                         LayerOpening{lazy, !lazy || opening.hash_others}));
        s.infos.push_back(s.layers.back()->info());
    }
}

SourceStack::~SourceStack() = default;
SourceStack::SourceStack(SourceStack&&) noexcept = default;
SourceStack& SourceStack::operator=(SourceStack&&) noexcept = default;

// --- heights ---

void SourceStack::State::sample_chunk(std::span<const Vec3> n, std::span<double> heights,
                                      std::span<std::int8_t> layer, std::span<double> weights) const {
    std::array<double, kChunk> lat, lon;
    to_degrees(n, std::span(lat).first(n.size()), std::span(lon).first(n.size()));
    sample_degrees(std::span(lat).first(n.size()), std::span(lon).first(n.size()), cap_of(n), heights, layer,
                   weights);
}

// Every layer is asked for the places that no layer before it has closed.
void SourceStack::State::sample_degrees(std::span<double> lat, std::span<double> lon, const Cap& cap,
                                        std::span<double> heights, std::span<std::int8_t> layer,
                                        std::span<double> weights) const {
    const std::size_t count = std::min(lat.size(), kChunk);
    if (count == 0) return;
    std::size_t open = count;
    Blend blend(count);
    std::array<double, kChunk> found, weight;
    std::array<std::uint8_t, kChunk> valid;
    std::array<std::size_t, kChunk> index;
    std::array<std::int8_t, kChunk> winner;
    for (std::size_t i = 0; i < open; ++i) index[i] = i;
    for (std::size_t k = 0; k < layers.size() && open > 0; ++k) {
        if (!layers[k]->may_meet(cap)) continue;
        const bool weighed = k + 1 < layers.size();
        layers[k]->sample({lat.data(), open}, {lon.data(), open}, cap, {found.data(), open},
                          {valid.data(), open}, std::span(weight).first(weighed ? open : 0));
        std::size_t left = 0;
        for (std::size_t i = 0; i < open; ++i) {
            if (valid[i] != 0) {
                if (!blend.any(index[i])) winner[index[i]] = static_cast<std::int8_t>(k);
                blend.add(index[i], found[i], weighed ? weight[i] : 1);
                if (blend.closed(index[i])) continue;
            }
            index[left] = index[i];
            lat[left] = lat[i];
            lon[left++] = lon[i];
        }
        open = left;
    }
    add_base(blend, {lat.data(), open}, {lon.data(), open}, {index.data(), open}, heights);
    for (std::size_t i = 0; i < count; ++i) {
        if (blend.any(i)) heights[i] = blend.height(i);
        if (!layer.empty()) layer[i] = blend.any(i) ? winner[i] : kBaseLayer;
        if (!weights.empty()) weights[i] = blend.any(i) ? blend.first_share(i) : 1;
    }
}

// The base height where no layer has one.
void SourceStack::State::add_base(const Blend& blend, std::span<const double> lat,
                                  std::span<const double> lon, std::span<const std::size_t> index,
                                  std::span<double> heights) const {
    const Geoid* geoid = layers.empty() ? nullptr : layers.back()->geoid();
    for (std::size_t k = 0; k < index.size(); ++k) {
        if (blend.any(index[k])) continue;
        double height = base_height;
        std::uint8_t valid = 1;
        if (geoid != nullptr) geoid->add(lat.subspan(k, 1), lon.subspan(k, 1), {&height, 1}, {&valid, 1});
        heights[index[k]] = height;
    }
}

void SourceStack::sample(std::span<const Vec3> n, std::span<double> heights,
                         std::span<std::int8_t> layer) const {
    if (heights.size() != n.size() || (!layer.empty() && layer.size() != n.size()))
        throw Error(ErrorCode::usage, "places, heights and layers differ in number");
    for (std::size_t start = 0; start < n.size(); start += kChunk) {
        const std::size_t count = std::min(kChunk, n.size() - start);
        state_->sample_chunk(n.subspan(start, count), heights.subspan(start, count),
                             layer.empty() ? layer : layer.subspan(start, count), {});
    }
}

void SourceStack::sample(std::span<const LatticePoint> points, std::span<double> heights) const {
    if (heights.size() != points.size()) throw Error(ErrorCode::usage, "points and heights differ in number");
    std::array<double, kChunk> lat, lon;
    for (std::size_t start = 0; start < points.size(); start += kChunk) {
        const std::size_t count = std::min(kChunk, points.size() - start);
        std::vector<Vec3> normals(count);
        for (std::size_t k = 0; k < count; ++k) {
            const LatticePoint& p = points[start + k];
            normals[k] = direction(p);
            const Vec3 w{lattice_tangent(p.x), lattice_tangent(p.y), lattice_tangent(p.z)};
            lat[k] = latitude_of_tangents(w);
            lon[k] = longitude_of_tangents(w[0], w[1]);
        }
        state_->sample_degrees({lat.data(), count}, {lon.data(), count}, cap_of(normals),
                               heights.subspan(start, count), {}, {});
    }
}

void SourceStack::sample(const Half& half, int cells, std::span<double> heights) const {
    if (heights.size() != half_vertex_count(cells))
        throw Error(ErrorCode::usage, "heights are not those of a half");
    const HalfDegrees degrees(half, cells);
    const Cap cap = cap_of_half(half);
    std::array<double, kChunk> lat, lon;
    std::size_t filled = 0, done = 0;
    const auto flush = [&] {
        state_->sample_degrees({lat.data(), filled}, {lon.data(), filled}, cap, heights.subspan(done, filled),
                               {}, {});
        done += filled;
        filled = 0;
    };
    for (int i = 0; i <= cells; ++i) {
        const int begin = half.side == 0 ? 0 : i, end = half.side == 0 ? i + 1 : cells + 1;
        if (filled + static_cast<std::size_t>(end - begin) > kChunk) flush();
        degrees.row(i, begin, end, lat.data() + filled, lon.data() + filled);
        filled += static_cast<std::size_t>(end - begin);
    }
    flush();
}

SourceStack::Value SourceStack::sample(const Vec3& n) const {
    double height = 0, weight = 1;
    std::int8_t layer = kBaseLayer;
    state_->sample_chunk({&n, 1}, {&height, 1}, {&layer, 1}, {&weight, 1});
    return {height, layer, weight};
}

// --- spacing ---

bool SourceStack::State::may_meet(const Cap& cap) const {
    return std::any_of(layers.begin(), layers.end(), [&](const auto& layer) { return layer->may_meet(cap); });
}

// Large halves are cut into their child halves, which tile them exactly.
double SourceStack::State::finest(const Half& half) const {
    if (half.diamond.level() >= kSmallHalfLevel) return finest_in_small(half, kMoreLevels);
    if (!may_meet(cap_of_half(half))) return kInfinity;
    const auto [first, second] = child_halves(half);
    return std::min(finest(first), finest(second));
}

// Where a higher layer has some samples and a lower one is finer, smaller halves tell which of the two wins.
double SourceStack::State::finest_in_small(const Half& half, int more_levels) const {
    const std::array<Vec3, 7> places = outline(half);
    Cap cap = cap_of(places);
    cap.radius *= 1.05;  // the sides bulge between the places
    double spacing = kInfinity;
    for (const auto& layer : layers) {
        const Coverage c = layer->cover(places, cap);
        if (c.spacing < spacing && std::isfinite(spacing) && more_levels > 0 &&
            half.diamond.level() < kDeepestId) {
            const auto [first, second] = child_halves(half);
            return std::min(finest_in_small(first, more_levels - 1),
                            finest_in_small(second, more_levels - 1));
        }
        spacing = std::min(spacing, c.spacing);
        if (c.full) break;
    }
    return spacing;
}

double SourceStack::finest_spacing(DiamondId d) const {
    return std::min(state_->finest({d, 0}), state_->finest({d, 1}));
}

bool SourceStack::may_touch(std::size_t layer, DiamondId d) const {
    const SourceLayer& l = *state_->layers[layer];
    for (const int side : {0, 1}) {
        const Half half{d, side};
        Cap cap = cap_of_half(half);
        if (!l.may_meet(cap)) continue;
        if (d.level() < kSmallHalfLevel) return true;
        const std::array<Vec3, 7> places = outline(half);
        cap = cap_of(places);
        cap.radius *= 1.05;  // the sides bulge between the places
        if (std::isfinite(l.cover(places, cap).spacing)) return true;
    }
    return false;
}

// Descendants of a diamond of circumradius R reach at most R (1/sqrt 2 + 1/2 + ...) = 2.41 R from its middle,
// which lies within R of the middle of each half's cap; the rest is for the cube's distortion.
bool SourceStack::may_reach(std::size_t layer, DiamondId d) const {
    constexpr double kReach = 4;
    for (const int side : {0, 1}) {
        Cap cap = cap_of_half({d, side});
        cap.radius *= kReach;
        if (state_->layers[layer]->may_meet(cap)) return true;
    }
    return false;
}

bool SourceStack::is_near(std::size_t layer, const Vec3& n) const {
    std::array<Vec3, 7> places;
    places.fill(n);
    const Cap cap = cap_of(places);
    const SourceLayer& l = *state_->layers[layer];
    return l.may_meet(cap) && std::isfinite(l.cover(places, cap).spacing);
}

int SourceStack::layer_near(const Vec3& n, std::optional<std::size_t> without) const {
    for (std::size_t k = 0; k < state_->layers.size(); ++k)
        if (k != without && is_near(k, n)) return static_cast<int>(k);
    return kBaseLayer;
}

SourceStack::Reads SourceStack::reads() const {
    Reads out;
    for (const auto& layer : state_->layers)
        for (const auto& grid : layer->grids()) {
            out.tiles += grid->tiles();
            out.reads += grid->tile_reads();
        }
    return out;
}

const std::vector<LayerInfo>& SourceStack::layers() const { return state_->infos; }
const std::vector<std::string>& SourceStack::warnings() const { return state_->warnings; }
const Ellipsoid& SourceStack::body() const { return state_->body; }
double SourceStack::base_height() const { return state_->base_height; }

}  // namespace carat
