// Weighted blending of heights from several sources, the first one uppermost. The rule stands in source.hpp.
#pragma once

#include <array>
#include <cstddef>

namespace carat {

// Places handled at a time.
inline constexpr std::size_t kChunk = 512;

// For up to kChunk places.
class Blend {
  public:
    explicit Blend(std::size_t count) {
        for (std::size_t i = 0; i < count; ++i) {
            remaining_[i] = 1;
            sources_[i] = 0;
            sum_[i] = total_[i] = 0;
        }
    }

    // One more source has a height, with weight 0..1, at place i.
    void add(std::size_t i, double height, double weight) {
        if (sources_[i]++ == 0) {
            first_[i] = height;
            first_weight_[i] = weight;
        }
        const double share = remaining_[i] * weight;
        sum_[i] += share * height;
        total_[i] += share;
        remaining_[i] *= 1 - weight;
    }

    // Nothing below matters any more.
    bool closed(std::size_t i) const { return remaining_[i] == 0; }
    bool any(std::size_t i) const { return sources_[i] > 0; }
    // Precondition for the rest: any(i). A single source gives its very height.
    double height(std::size_t i) const { return alone(i) ? first_[i] : sum_[i] / total_[i]; }
    double weight(std::size_t i) const { return 1 - remaining_[i]; }
    // Share of the first source in the height.
    double first_share(std::size_t i) const { return alone(i) ? 1 : first_weight_[i] / total_[i]; }

  private:
    bool alone(std::size_t i) const { return sources_[i] == 1 || !(total_[i] > 1e-9); }

    std::array<double, kChunk> sum_, total_, remaining_, first_, first_weight_;
    std::array<int, kChunk> sources_;
};

}  // namespace carat
