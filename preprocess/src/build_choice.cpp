#include "build_choice.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "build_trial.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr std::size_t kSampled = 512;  // diamonds: two million values for N = 65
// The share of the promised RMS that the sample may use up; the rest allows for the difference between sample
// and file.
constexpr double kAim = 0.985;
// The greatest error is at most this many times the RMS: without a limit nothing would be kept of small hills
// in a plain.
constexpr double kMostOverRms = 8;

class Sample {
  public:
    Sample(const BuildOptions& options, const SourceStack& sources, const RefinedLevels& levels)
        : options_(options) {
        const std::vector<DiamondId> some = spread_diamonds(levels, kSampled);
        trials_.resize(some.size());
        tbb::parallel_for(std::size_t{0}, some.size(), [&](std::size_t k) {
            trials_[k] = std::make_unique<Trial>(options_, sources);
            trials_[k]->take(some[k]);
        });
    }
    bool empty() const { return trials_.empty(); }
    std::size_t size() const { return trials_.size(); }

    // Quanta, the rounding to the quantum included.
    double rms(std::int32_t radius) {
        std::vector<Trial::Result> results(trials_.size());
        tbb::parallel_for(std::size_t{0}, trials_.size(), [&](std::size_t k) {
            results[k] = trials_[k]->code(options_.coding, radius, nullptr);
        });
        double squares = 0, values = 0;
        for (const Trial::Result& r : results) {
            squares += r.squares;
            values += static_cast<double>(r.values);
        }
        return std::sqrt(squares / values + 1.0 / 12);
    }
    RangeStatistics tokens(std::int32_t radius) {
        tbb::enumerable_thread_specific<RangeStatistics> counts;
        tbb::parallel_for(std::size_t{0}, trials_.size(),
                          [&](std::size_t k) { trials_[k]->code(options_.coding, radius, &counts.local()); });
        RangeStatistics sum;
        for (const RangeStatistics& c : counts) sum.merge(c);
        return sum;
    }

  private:
    const BuildOptions& options_;
    std::vector<std::unique_ptr<Trial>> trials_;
};

// The greatest radius whose sample keeps the RMS, by bisection: it grows with the radius but for noise.
std::int32_t radius_for(Sample& sample, double rms_quanta, std::int32_t most) {
    if (sample.empty() || sample.rms(most) <= kAim * rms_quanta) return most;
    std::int32_t good = 0, bad = most;
    while (bad - good > std::max(1, good / 64)) {
        const std::int32_t middle = good + (bad - good) / 2;
        (sample.rms(middle) <= kAim * rms_quanta ? good : bad) = middle;
    }
    return good;
}

std::size_t diamonds_of(const RefinedLevels& levels) {
    std::size_t sum = 0;
    for (const auto& level : levels) sum += level.size();
    return sum;
}

// Fitted tables where they save more than they take, else the built-in ones. of_all: diamonds for each of the
// sample.
std::shared_ptr<const RangeTables> best_tables(const RangeStatistics& tokens, double of_all) {
    auto built_in = RangeTables::built_in(), fitted = RangeTables::fit(tokens);
    const double saved = (built_in->bits(tokens) - fitted->bits(tokens)) * of_all;
    return saved > 8.0 * static_cast<double>(fitted->bytes().size()) ? fitted : built_in;
}

}  // namespace

double tolerance_of(std::int32_t radius, double quantum) { return (radius + 0.5) * quantum; }

BuildOptions chosen_options(const BuildOptions& options, const SourceStack& sources,
                            const RefinedLevels& levels) {
    BuildOptions out = options;
    if (options.rms && !options.quantum) out.quantum = default_quantum(*options.rms);
    const bool fits = options.fit_tables && options.coding.coder == CoderId::range;
    if (!options.rms && !fits) return out;
    Sample sample(out, sources, levels);
    const double quantum = out.quantum.value_or(default_quantum(options.tolerance));
    if (options.rms) {
        if (*options.rms < 0.6 * quantum)
            throw Error(ErrorCode::usage, "an RMS error of " + std::to_string(*options.rms) +
                                              " m needs a quantum of at most " +
                                              std::to_string(*options.rms / 0.6) + " m");
        const double limit = std::min(options.tolerance, kMostOverRms * *options.rms);
        const std::int32_t most = quantizer_radius(std::max(limit, quantum), quantum);
        out.tolerance = tolerance_of(radius_for(sample, *options.rms / quantum, most), quantum);
    }
    if (fits) {
        const double of_all = static_cast<double>(diamonds_of(levels)) /
                              static_cast<double>(std::max<std::size_t>(1, sample.size()));
        out.coding.tables = best_tables(sample.tokens(quantizer_radius(out.tolerance, quantum)), of_all);
    }
    return out;
}

BuildOptions with_smaller_step(const BuildOptions& options, double found) {
    BuildOptions out = options;
    const std::int32_t radius = quantizer_radius(options.tolerance, *options.quantum);
    if (radius == 0) throw Error(ErrorCode::usage, "no step keeps this RMS error; a smaller --quantum may");
    const auto smaller = static_cast<std::int32_t>(radius * kAim * *options.rms / found);
    out.tolerance = tolerance_of(std::clamp(smaller, 0, radius - 1), *options.quantum);
    return out;
}

}  // namespace carat
