#include "carat/render/detail.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "carat/globe/error.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/cut.hpp"
#include "detail_code.hpp"
#include "detail_kernel.hpp"
#include "detail_roughness.hpp"
#include "half_kernel.hpp"

namespace carat {
namespace {

constexpr double kShare = 2;               // of delta of the half above a leaf
constexpr double kReliefShare = 1.0 / 16;  // of the file's whole relief
constexpr double kAxisShare = 1.0 / 4096;  // of the semi-axis: uniform detail
constexpr int kLookBeneath = 4;            // levels
constexpr int kBandLevels = 6;             // of a page: looking no further reads nothing more
// Everything that all levels add at most, in units of the first: 1 / (1 - 2^-decay), and what the linear
// mantissa may add.
constexpr double kLinearMantissa = 1.0615;
constexpr double kLeastDecayFactor = 1 / (1 - 0.81190) * kLinearMantissa;  // 2^(-77/256) < 0.81190
constexpr double kUniformDecayFactor = 1 / (1 - 0.70711) * kLinearMantissa;
constexpr int kUniformDecay = 128;  // spacing and residuals halve in two levels
// Rounding to 2^-25 quanta, once a level.
constexpr double kRounding = 64 * kHeightFraction;

void check(bool ok, const char* what) {
    if (!ok) throw Error(ErrorCode::usage, std::string("--detail: ") + what);
}

std::uint64_t mixed(std::uint64_t x) {  // SplitMix64
    x += 0x9E3779B97F4A7C15u;
    x = (x ^ (x >> 30)) * 0xBF58476D1CE4E5B9u;
    x = (x ^ (x >> 27)) * 0x94D049BB133111EBu;
    return x ^ (x >> 31);
}

int limited_log(double quanta) {
    if (!(quanta > 0)) return kNoAmplitude;
    return std::clamp(linear_log2(quanta), kNoAmplitude, kGreatestAmplitude);
}

// Centres of the cells of a level lie on multiples of its half-size / cells.
CellGrid cell_grid(const Half& half, int level, int cells) {
    const HalfFrame f = half_frame(half, cells);
    const std::int64_t step = half_size(level) / cells;
    CellGrid out;
    for (int axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<std::size_t>(axis);
        out.u[k] = static_cast<std::int32_t>(f.u[axis] / step);
        out.v[k] = static_cast<std::int32_t>(f.v[axis] / step);
        out.origin[k] = static_cast<std::int32_t>((2 * f.origin[axis] + f.u[axis] + f.v[axis]) / (2 * step));
    }
    return out;
}

// Both halves give the diagonal: the lesser amplitude, so that no half's residuals exceed its own bound.
void fill_roughness(const HalfHeights& half0, const HalfHeights& half1, int cells, std::int32_t* out) {
    const int n = cells + 1;
    transpose_half(half1.rough, cells, out);
    const std::int32_t* row = half0.rough.data();
    for (int i = 0; i <= cells; row += ++i) {
        std::int32_t* to = out + i * n;
        const std::int32_t a = row[i], b = to[i];
        std::copy_n(row, i, to);
        to[i] =
            pack_roughness(std::min(amplitude_of(a), amplitude_of(b)), std::max(decay_of(a), decay_of(b)));
    }
}

// Greatest amplitude and least decay.
std::array<int, 2> extremes(const HalfHeights& heights) {
    std::int32_t most = kNoAmplitude, least = 0xFFFF;
    for (const std::int32_t r : heights.rough) {
        most = std::max(most, amplitude_of(r));
        least = std::min(least, decay_of(r));
    }
    return {most, least};
}

}  // namespace

Detail::Detail(const RepositoryHeader& header, const DetailOptions& options)
    : options_(options), cells_(header.cells()), quantum_(header.quantum) {
    const double amplitude = options.amplitude.value_or(options.uniform ? 0.05 : 1);
    check(amplitude >= 0 && amplitude <= 100, "amplitude must be between 0 and 100");
    check(options.to > 0 && std::isfinite(options.to), "to must be a positive number of metres");
    check(options.slope > 0 && options.slope <= 80, "slope must be in (0, 80] degrees");
    factor_ = amplitude;
    const double mean_square = (2 * header.body_a * header.body_a + header.body_b * header.body_b) / 3;
    const double face = std::sqrt(4 * std::numbers::pi * mean_square / 6);  // side of a square
    const double tangent = std::tan(options.slope * std::numbers::pi / 180);
    end_level_ = deepest_refinable_level(header.log2_cells) + 1;
    for (int level = 0; level < static_cast<int>(spacings_.size()); ++level) {
        const double s = face / cells_ * std::sqrt(std::ldexp(1.0, -level));
        spacings_[static_cast<std::size_t>(level)] = s;
        double most = tangent * s * (std::numbers::sqrt2 / 2);
        if (options.uniform) most = std::min(most, amplitude * s);
        caps_[static_cast<std::size_t>(level)] = limited_log(most / quantum_);
        if (s <= options.to) end_level_ = std::min(end_level_, level);
    }
    const double relief = quantum_ * (double{1.0} * header.max_height - header.min_height);
    greatest_ = options.uniform ? header.body_a * kAxisShare : relief * kReliefShare;
    if (amplitude == 0) greatest_ = 0;
}

double Detail::share_of_delta(double delta) const {
    return options_.uniform ? greatest_ : std::min(kShare * delta, greatest_);
}

void Detail::begin(const Repository& repository, const Half& leaf, HalfHeights& heights) const {
    heights.rough.resize(heights.size());
    const int level = leaf.diamond.level();
    const int cap = caps_[static_cast<std::size_t>(level)];
    if (options_.uniform) {
        const int most = std::min(cap, limited_log(greatest_ / (kUniformDecayFactor * quantum_)));
        std::fill(heights.rough.begin(), heights.rough.end(), pack_roughness(most, kUniformDecay));
        return;
    }
    const std::optional<Half> above = parent_half(leaf);
    const double share = above ? share_of_delta(repository.summary(*above).delta) : greatest_;
    const int most = std::min(cap, limited_log(share / (kLeastDecayFactor * quantum_)));
    const int factor = factor_ > 0 ? linear_log2(factor_) : kNoAmplitude;
    estimate_roughness(heights.whole, cells_, factor, most, heights.rough);
}

void Detail::refine(DiamondId diamond, int level, const HalfHeights& half0, const HalfHeights& half1,
                    VirtualHeights& out) const {
    if (level >= end_level_ || half0.rough.empty() || half1.rough.empty()) {
        out = refine_virtually(half0, half1, cells_);
        return;
    }
    const auto n = static_cast<std::size_t>(cells_ + 1), cells = static_cast<std::size_t>(cells_);
    out.n = cells_ + 1;
    out.v.resize(n * n + kSynthesisPadding);
    out.c.resize(cells * cells + kSynthesisPadding);
    out.rough_v.resize(n * n + kSynthesisPadding);
    out.rough_c.resize(cells * cells + kSynthesisPadding);
    std::fill(out.v.end() - kSynthesisPadding, out.v.end(), 0);
    std::fill(out.rough_v.end() - kSynthesisPadding, out.rough_v.end(), 0);
    virtual_vertices(half0, half1, cells_, out.v.data());
    fill_roughness(half0, half1, cells_, out.rough_v.data());
    SynthesisJob job;
    job.cells = cells_;
    for (const int side : {0, 1})
        job.sides[static_cast<std::size_t>(side)] = cell_grid({diamond, side}, level, cells_);
    job.salt =
        static_cast<std::uint32_t>(mixed(options_.seed + mixed(static_cast<std::uint64_t>(level))) >> 32);
    job.cap = caps_[static_cast<std::size_t>(level)];
    synthesise_centres(job, out.v.data(), out.rough_v.data(), out.c.data(), out.rough_c.data());
    decay_roughness(job.cap, out.rough_v.data(), n * n);
}

// Greatest residuals of a level and all below it, metres.
double Detail::sum_of(int level, int amplitude, int decay) const {
    double sum = 0;
    for (; level < end_level_; ++level, amplitude -= decay) {
        amplitude = std::min(amplitude, int{caps_[static_cast<std::size_t>(level)]});
        if (amplitude < kLeastAmplitude) break;
        sum += linear_exp2(amplitude);
    }
    return quantum_ * (sum + kRounding);
}

double Detail::bound(int level, const HalfHeights& heights) const {
    if (heights.rough.empty() || level >= end_level_) return 0;
    const auto [amplitude, decay] = extremes(heights);
    return sum_of(level, amplitude, decay);
}

bool Detail::shows(int level, const HalfHeights& heights) const {
    if (heights.rough.empty() || level >= end_level_) return false;
    const int amplitude = extremes(heights)[0];
    return amplitude >= kLeastAmplitude && 256 * quantum_ * linear_exp2(amplitude) > spacing(level);
}

double Detail::bound_beneath(const Repository& repository, const Half& half) const {
    const int level = half.diamond.level();
    if (options_.uniform)
        return std::min(greatest_, sum_of(level, caps_[static_cast<std::size_t>(level)], kUniformDecay));
    if (greatest_ == 0) return 0;
    const std::optional<Half> above = parent_half(half);
    const double parent_delta = above ? repository.summary(*above).delta : greatest_;
    const int to_band = kBandLevels - 1 - level % kBandLevels;
    return std::min(look_beneath(repository, half, level, parent_delta, std::min(kLookBeneath, to_band)),
                    greatest_) +
           quantum_ * kRounding;
}

// Beneath a leaf: its share of the delta above it. Elsewhere delta is that of the half, which no descendant's
// exceeds.
double Detail::look_beneath(const Repository& repository, const Half& half, int level, double parent_delta,
                            int levels) const {
    if (level >= end_level_) return 0;
    if (!repository.refined(half.diamond)) return share_of_delta(parent_delta);
    const double delta = repository.summary(half).delta;
    if (levels == 0) return share_of_delta(delta);
    double most = 0;
    for (const Half& child : child_halves(half))
        most = std::max(most, look_beneath(repository, child, level + 1, delta, levels - 1));
    return most;
}

}  // namespace carat
