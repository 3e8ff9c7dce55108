#include "detail_roughness.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cstddef>

#include "carat/globe/patch.hpp"
#include "detail_code.hpp"

namespace carat {
namespace {

constexpr int kFar = 4;  // cells: the wider of the two spacings

struct Roughness {
    int amplitude = kNoAmplitude, decay = kDefaultDecay;
};

// Squares of second differences at two spacings. Held to 2^24 quanta, so that sums of 2^13 fit.
struct Energy {
    std::uint64_t near = 0, far = 0;
    std::uint32_t near_count = 0, far_count = 0;

    static std::uint64_t square(std::int64_t before, std::int64_t at, std::int64_t after) {
        constexpr std::int64_t kMost = 1 << 24;
        const std::int64_t d = std::clamp(2 * at - before - after, -kMost, kMost);
        return static_cast<std::uint64_t>(d * d);
    }
    // log2 of the mean, in 1/256.
    static int log_mean(std::uint64_t sum, std::uint32_t count) {
        return linear_log2(sum) - linear_log2(std::uint64_t{count});
    }

    Roughness roughness() const {
        Roughness out;
        if (near == 0 || near_count == 0) return out;
        // sigma^2 = mean / 4.
        const int sigma = log_mean(near, near_count) / 2 - kOctave;
        if (far > 0 && far_count > 0) {
            const int far_sigma = log_mean(far, far_count) / 2 - kOctave;
            // 4 = 2^2 in spacing is four levels.
            out.decay = std::clamp((far_sigma - sigma) / 4, kLeastDecay, kGreatestDecay);
        }
        // The greatest residual is two sigma; the first has half the cell's diagonal.
        out.amplitude = sigma + kOctave - out.decay;
        return out;
    }
};

Roughness mix(const Roughness& a, const Roughness& b, int share, int whole) {
    return {(a.amplitude * (whole - share) + b.amplitude * share) / whole,
            (a.decay * (whole - share) + b.decay * share) / whole};
}

// Between the middles of equal parts; constant beyond the first and the last. x counts from the first part's
// beginning.
struct Between {
    int first, second, share, whole;
    Between(int x, int part, int parts) : whole(2 * part) {
        const int from_middle = 2 * x - part;
        first = std::clamp(from_middle / whole, 0, parts - 1);
        second = std::min(first + 1, parts - 1);
        share = std::clamp(from_middle - first * whole, 0, whole);
    }
};

constexpr int kEdgeParts = 4, kBlocks = 8;  // along a side, at most

class Estimate {
  public:
    Estimate(std::span<const std::int32_t> heights, int cells)
        : h_(heights), cells_(cells), block_(std::max(4, cells / kBlocks)), blocks_(cells / block_) {
        part_ = std::max(4, cells / kEdgeParts);
        parts_ = cells / part_;
        for (int edge = 0; edge < 3; ++edge) measure_edge(edge);
        measure_blocks();
    }

    Roughness at(int r, int c) const {
        const std::array<int, 3> distance{c, cells_ - r, r - c};
        const std::array<int, 3> along{r, c, r};
        for (std::size_t k = 0; k < 3; ++k)
            if (distance[k] == 0) return on_edge(k, along[k]);
        if (is_level(r, c)) return {};
        constexpr std::int64_t kOne = 1 << 14;
        Roughness inside = in_block(r, c);
        std::int64_t weight = kOne / (block_ * block_), sum = weight;
        std::int64_t amplitude = weight * inside.amplitude, decay = weight * inside.decay;
        for (std::size_t k = 0; k < 3; ++k) {
            if (distance[k] > 2 * block_) continue;
            weight = kOne / (distance[k] * distance[k]);
            const Roughness& edge = on_edge(k, along[k]);
            amplitude += weight * edge.amplitude;
            decay += weight * edge.decay;
            sum += weight;
        }
        return {static_cast<int>(amplitude / sum), static_cast<int>(decay / sum)};
    }

  private:
    std::int32_t h(int r, int c) const { return h_[half_vertex_index(r, c)]; }
    // Edges: 0 c = 0, 1 r = cells, 2 the longest.
    std::int32_t edge_height(std::size_t edge, int k) const {
        return edge == 0 ? h(k, 0) : edge == 1 ? h(cells_, k) : h(k, k);
    }

    void measure_edge(int edge) {
        const auto e = static_cast<std::size_t>(edge);
        std::array<Energy, kEdgeParts> energy;
        const auto height = [&](int k) { return edge_height(e, k); };
        for (int k = 1; k < cells_; ++k) {
            Energy& in = energy[static_cast<std::size_t>(std::min(k / part_, parts_ - 1))];
            in.near += Energy::square(height(k - 1), height(k), height(k + 1));
            ++in.near_count;
            if (k < kFar || k > cells_ - kFar) continue;
            in.far += Energy::square(height(k - kFar), height(k), height(k + kFar));
            ++in.far_count;
        }
        std::array<Roughness, kEdgeParts> parts;
        for (std::size_t k = 0; k < parts.size(); ++k) {
            parts[k] = energy[k].roughness();
            if (edge == 2) parts[k].amplitude -= parts[k].decay;  // its vertices lie a level further apart
        }
        for (int k = 0; k <= cells_; ++k) {
            const int before = height(std::max(k - 1, 0)), after = height(std::min(k + 1, cells_));
            const Between b(k, part_, parts_);
            edges_[e][static_cast<std::size_t>(k)] =
                before == height(k) && after == height(k)
                    ? Roughness{}
                    : mix(parts[static_cast<std::size_t>(b.first)], parts[static_cast<std::size_t>(b.second)],
                          b.share, b.whole);
        }
    }

    void measure_blocks() {
        std::array<std::array<Energy, kBlocks>, kBlocks> energy;
        for (int r = 1; r < cells_; ++r)
            for (int c = 1; c < r; ++c) {
                Energy& in =
                    energy[static_cast<std::size_t>(r / block_)][static_cast<std::size_t>(c / block_)];
                in.near += Energy::square(h(r, c - 1), h(r, c), h(r, c + 1));
                in.near += Energy::square(h(r - 1, c), h(r, c), h(r + 1, c));
                in.near_count += 2;
                if (c >= kFar && c + kFar <= r) {
                    in.far += Energy::square(h(r, c - kFar), h(r, c), h(r, c + kFar));
                    ++in.far_count;
                }
                if (r + kFar <= cells_ && r - kFar >= c) {
                    in.far += Energy::square(h(r - kFar, c), h(r, c), h(r + kFar, c));
                    ++in.far_count;
                }
            }
        for (int r = 0; r < blocks_; ++r)
            for (int c = 0; c <= r; ++c)
                block(r, c) = energy[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)].roughness();
    }

    Roughness& block(int r, int c) {
        return inner_[static_cast<std::size_t>(r)][static_cast<std::size_t>(c)];
    }
    const Roughness& block(int r, int c) const {
        return inner_[static_cast<std::size_t>(r)][static_cast<std::size_t>(std::min(c, r))];
    }
    Roughness in_block(int r, int c) const {
        const Between y(r, block_, blocks_), x(c, block_, blocks_);
        return mix(mix(block(y.first, x.first), block(y.first, x.second), x.share, x.whole),
                   mix(block(y.second, x.first), block(y.second, x.second), x.share, x.whole), y.share,
                   y.whole);
    }
    const Roughness& on_edge(std::size_t edge, int k) const {
        return edges_[edge][static_cast<std::size_t>(k)];
    }
    bool is_level(int r, int c) const {
        const std::int32_t x = h(r, c);
        return h(r - 1, c) == x && h(r + 1, c) == x && h(r, c - 1) == x && h(r, c + 1) == x;
    }

    std::span<const std::int32_t> h_;
    int cells_, block_, blocks_, part_ = 0, parts_ = 0;
    std::array<std::array<Roughness, 129>, 3> edges_;
    std::array<std::array<Roughness, kBlocks>, kBlocks> inner_;
};

}  // namespace

void estimate_roughness(std::span<const std::int32_t> heights, int cells, int factor, int greatest,
                        std::span<std::int32_t> out) {
    assert(heights.size() == half_vertex_count(cells) && out.size() == heights.size());
    const Estimate estimate(heights, cells);
    std::size_t k = 0;
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c, ++k) {
            const Roughness x = estimate.at(r, c);
            out[k] = pack_roughness(std::clamp(x.amplitude + factor, kNoAmplitude, greatest), x.decay);
        }
}

}  // namespace carat
