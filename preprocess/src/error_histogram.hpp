// Counts of magnitudes in bins of equal ratio, for percentiles that do not depend on the order of counting.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <vector>

namespace carat {

// 64 bins an octave from 2^-16 to 2^16 metres; what lies beyond goes to the first or last bin.
class ErrorHistogram {
  public:
    ErrorHistogram() : counts_(kBins, 0) {}

    void add(double magnitude) { ++counts_[bin(magnitude)]; }
    void add(const ErrorHistogram& other) {
        for (std::size_t k = 0; k < kBins; ++k) counts_[k] += other.counts_[k];
    }
    // A value that at least `share` of the magnitudes do not exceed: the upper edge of a bin.
    double percentile(double share) const {
        std::uint64_t total = 0, below = 0;
        for (const std::uint64_t c : counts_) total += c;
        const double wanted = share * static_cast<double>(total);
        for (std::size_t k = 0; k < kBins; ++k) {
            below += counts_[k];
            if (below > 0 && static_cast<double>(below) >= wanted) return upper_edge(k);
        }
        return 0;
    }

  private:
    // The six leading bits of a double's fraction cut an octave into 64.
    static constexpr int kShift = 46;
    static constexpr std::uint64_t kFirst = std::bit_cast<std::uint64_t>(0x1p-16) >> kShift;
    static constexpr std::uint64_t kLast = std::bit_cast<std::uint64_t>(0x1p16) >> kShift;
    static constexpr std::size_t kBins = static_cast<std::size_t>(kLast - kFirst) + 2;

    static std::size_t bin(double magnitude) {
        const std::uint64_t b = std::bit_cast<std::uint64_t>(magnitude) >> kShift;
        return static_cast<std::size_t>(std::clamp(b, kFirst - 1, kLast) - (kFirst - 1));
    }
    static double upper_edge(std::size_t k) {
        return std::bit_cast<double>((kFirst + static_cast<std::uint64_t>(k)) << kShift);
    }

    std::vector<std::uint64_t> counts_;
};

}  // namespace carat
