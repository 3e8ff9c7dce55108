#include "carat/preprocess/source.hpp"

#include <gdal.h>

#include <algorithm>
#include <array>
#include <limits>

#include "cap.hpp"
#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "frame.hpp"
#include "gdal_errors.hpp"
#include "source_layer.hpp"

namespace carat {
namespace {

constexpr std::size_t kChunk = 512;
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

}  // namespace

struct SourceStack::State {
    State(const Ellipsoid& b, double height, std::size_t cache_bytes)
        : body(b), base_height(height), cache(cache_bytes) {}

    void sample_chunk(std::span<const Vec3> n, std::span<double> heights, std::span<std::int8_t> layer) const;
    double finest(const Half& half) const;
    double finest_in_small(const Half& half, int more_levels) const;
    bool may_meet(const Cap& cap) const;

    Ellipsoid body;
    double base_height;
    HandlePool handles;
    TileCache cache;
    std::vector<std::string> warnings;
    std::vector<std::unique_ptr<SourceLayer>> layers;
    std::vector<LayerInfo> infos;
};

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

SourceStack::SourceStack(const std::vector<LayerOptions>& layers, const Ellipsoid& body, double base_height,
                         std::size_t cache_bytes)
    : state_(std::make_unique<State>(body, base_height, cache_bytes)) {
    if (layers.size() > kMaxLayers)
        throw Error(ErrorCode::limit,
                    std::to_string(layers.size()) + " layers, more than " + std::to_string(kMaxLayers));
    if (!std::isfinite(base_height)) throw Error(ErrorCode::usage, "the base height is not finite");
    initialise_gdal();
    State& s = *state_;
    for (const LayerOptions& options : layers) {
        const std::uint64_t key = s.layers.size() * kKeysPerLayer;
        s.layers.push_back(std::make_unique<SourceLayer>(options, body, s.handles, s.cache, key, s.warnings));
        s.infos.push_back(s.layers.back()->info());
    }
}

SourceStack::~SourceStack() = default;
SourceStack::SourceStack(SourceStack&&) noexcept = default;
SourceStack& SourceStack::operator=(SourceStack&&) noexcept = default;

// --- heights ---

void SourceStack::State::sample_chunk(std::span<const Vec3> n, std::span<double> heights,
                                      std::span<std::int8_t> layer) const {
    std::array<double, kChunk> lat, lon, found;
    std::array<std::uint8_t, kChunk> valid;
    std::array<std::size_t, kChunk> index;
    std::size_t missing = n.size();
    to_degrees(n, std::span(lat).first(missing), std::span(lon).first(missing));
    for (std::size_t i = 0; i < missing; ++i) index[i] = i;
    const Cap cap = cap_of(n);
    for (std::size_t k = 0; k < layers.size() && missing > 0; ++k) {
        if (!layers[k]->may_meet(cap)) continue;
        layers[k]->sample(std::span<const double>(lat).first(missing),
                          std::span<const double>(lon).first(missing), cap, std::span(found).first(missing),
                          std::span(valid).first(missing));
        std::size_t left = 0;
        for (std::size_t i = 0; i < missing; ++i) {
            if (valid[i] != 0) {
                heights[index[i]] = found[i];
                if (!layer.empty()) layer[index[i]] = static_cast<std::int8_t>(k);
                continue;
            }
            index[left] = index[i];
            lat[left] = lat[i];
            lon[left++] = lon[i];
        }
        missing = left;
    }
    if (missing == 0) return;
    std::fill_n(found.begin(), missing, base_height);
    std::fill_n(valid.begin(), missing, std::uint8_t{1});
    if (!layers.empty() && layers.back()->geoid() != nullptr)
        layers.back()->geoid()->add(std::span<const double>(lat).first(missing),
                                    std::span<const double>(lon).first(missing),
                                    std::span(found).first(missing), std::span(valid).first(missing));
    for (std::size_t i = 0; i < missing; ++i) {
        heights[index[i]] = found[i];
        if (!layer.empty()) layer[index[i]] = kBaseLayer;
    }
}

void SourceStack::sample(std::span<const Vec3> n, std::span<double> heights,
                         std::span<std::int8_t> layer) const {
    if (heights.size() != n.size() || (!layer.empty() && layer.size() != n.size()))
        throw Error(ErrorCode::usage, "places, heights and layers differ in number");
    for (std::size_t start = 0; start < n.size(); start += kChunk) {
        const std::size_t count = std::min(kChunk, n.size() - start);
        state_->sample_chunk(n.subspan(start, count), heights.subspan(start, count),
                             layer.empty() ? layer : layer.subspan(start, count));
    }
}

SourceStack::Value SourceStack::sample(const Vec3& n) const {
    double height = 0;
    std::int8_t layer = kBaseLayer;
    sample({&n, 1}, {&height, 1}, {&layer, 1});
    return {height, layer};
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

const std::vector<LayerInfo>& SourceStack::layers() const { return state_->infos; }
const std::vector<std::string>& SourceStack::warnings() const { return state_->warnings; }
const Ellipsoid& SourceStack::body() const { return state_->body; }
double SourceStack::base_height() const { return state_->base_height; }

}  // namespace carat
