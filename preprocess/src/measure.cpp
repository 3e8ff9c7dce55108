#include "carat/preprocess/measure.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <mutex>
#include <optional>

#include "carat/globe/error.hpp"
#include "error_histogram.hpp"
#include "measure_blocks.hpp"

namespace carat {
namespace {

// Sums over the samples of a block, in their order; added up in the order of blocks, they come out the same
// whatever thread did what.
struct Sums {
    std::uint64_t count = 0;
    double max = 0, sum = 0, squares = 0;

    void add(double error) {
        ++count;
        max = std::max(max, std::abs(error));
        sum += error;
        squares += error * error;
    }
    void add(const Sums& other) {
        count += other.count;
        max = std::max(max, other.max);
        sum += other.sum;
        squares += other.squares;
    }
};

struct BlockErrors {
    Sums compared, blended;
    std::uint64_t hidden = 0;
    WorstPlace worst;
};

struct LayerHistograms {
    ErrorHistogram compared, blended;
};

struct Worker {
    Worker(const LeafSurface& s, std::size_t layers) : surface(s), histograms(layers) {}

    LeafEvaluator surface;
    BlockSamples samples;
    std::vector<LayerHistograms> histograms;
};

BlockErrors compare(Worker& w, LayerHistograms& histograms) {
    BlockErrors out;
    out.hidden = w.samples.hidden;
    const RealLattice* worst = nullptr;
    for (std::size_t k = 0; k < w.samples.places.size(); ++k) {
        const RealLattice& place = w.samples.places[k];
        const double height = w.samples.heights[k], s = w.surface(place), error = s - height;
        if (w.samples.blended[k] != 0) {
            out.blended.add(error);
            histograms.blended.add(std::abs(error));
            continue;
        }
        if (worst == nullptr || std::abs(error) > out.compared.max) {
            worst = &place;
            out.worst.source = height;
            out.worst.surface = s;
        }
        out.compared.add(error);
        histograms.compared.add(std::abs(error));
    }
    if (worst != nullptr) {
        const Geodetic g = geodetic(direction(*worst));
        out.worst.latitude = g.latitude;
        out.worst.longitude = g.longitude;
    }
    return out;
}

ErrorStats stats(const Sums& s, const ErrorHistogram& histogram) {
    ErrorStats out;
    out.count = s.count;
    if (s.count == 0) return out;
    const auto n = static_cast<double>(s.count);
    const auto percentile = [&](double share) { return std::min(s.max, histogram.percentile(share)); };
    out.max = s.max;
    out.rms = std::sqrt(s.squares / n);
    out.mean = s.sum / n;
    out.p50 = percentile(0.5);
    out.p90 = percentile(0.9);
    out.p99 = percentile(0.99);
    out.p999 = percentile(0.999);
    return out;
}

double size_of(const WorstPlace& w) { return std::abs(w.surface - w.source); }

ErrorSummary summary_of(const SourceStack& sources, const std::vector<SampleBlock>& blocks,
                        const std::vector<BlockErrors>& errors,
                        const std::vector<LayerHistograms>& histograms, std::size_t worst_places) {
    ErrorSummary out;
    Sums all;
    ErrorHistogram all_histogram;
    std::size_t at = 0;
    for (std::size_t layer = 0; layer < sources.layers().size(); ++layer) {
        LayerErrors& l = out.layers.emplace_back();
        l.name = sources.layers()[layer].name;
        Sums compared, blended;
        for (; at < blocks.size() && blocks[at].layer == static_cast<int>(layer); ++at) {
            compared.add(errors[at].compared);
            blended.add(errors[at].blended);
            l.hidden += errors[at].hidden;
            if (errors[at].compared.count > 0) l.worst.push_back(errors[at].worst);
        }
        l.compared = stats(compared, histograms[layer].compared);
        l.blended = stats(blended, histograms[layer].blended);
        std::stable_sort(l.worst.begin(), l.worst.end(),
                         [](const auto& a, const auto& b) { return size_of(a) > size_of(b); });
        l.worst.resize(std::min(l.worst.size(), worst_places));
        all.add(compared);
        all_histogram.add(histograms[layer].compared);
    }
    out.all = stats(all, all_histogram);
    return out;
}

// Hands the caller's progress function what many threads have done.
class Progress {
  public:
    Progress(const MeasureOptions& options, std::uint64_t total) : options_(options), total_(total) {}

    void step(std::uint64_t samples) {
        const std::uint64_t done = done_ += samples;
        if (!options_.progress) return;
        const std::unique_lock lock(mutex_, std::try_to_lock);
        if (lock && !options_.progress(done, total_)) cancelled_ = true;
        if (cancelled_) throw Error(ErrorCode::usage, "cancelled");
    }

  private:
    const MeasureOptions& options_;
    std::uint64_t total_;
    std::atomic<std::uint64_t> done_{0};
    std::atomic<bool> cancelled_{false};
    std::mutex mutex_;
};

}  // namespace

std::uint64_t samples_in(const std::vector<SampleBlock>& blocks) {
    std::uint64_t sum = 0;
    for (const SampleBlock& b : blocks)
        sum += static_cast<std::uint64_t>(b.window.width) * static_cast<std::uint64_t>(b.window.height);
    return sum;
}

ErrorSummary measure_blocks(const SourceStack& sources, const LeafSurface& surface, std::size_t worst_places,
                            const SampleStep& step) {
    const SourceSamples samples(sources);
    const std::vector<SampleBlock>& blocks = samples.blocks();
    const std::size_t layers = sources.layers().size();
    std::vector<BlockErrors> errors(blocks.size());
    tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(surface, layers); });
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t k) {
        Worker& w = workers.local();
        samples.read(blocks[k], w.samples);
        errors[k] = compare(w, w.histograms[static_cast<std::size_t>(blocks[k].layer)]);
        step(samples_in({blocks[k]}));
    });
    std::vector<LayerHistograms> histograms(layers);
    for (const Worker& w : workers)
        for (std::size_t k = 0; k < layers; ++k) {
            histograms[k].compared.add(w.histograms[k].compared);
            histograms[k].blended.add(w.histograms[k].blended);
        }
    return summary_of(sources, blocks, errors, histograms, worst_places);
}

ErrorSummary measure_errors(const SourceStack& sources, std::shared_ptr<const Repository> file,
                            const MeasureOptions& options) {
    const RepositoryHeader& h = file->header();
    if (h.body_a != sources.body().a() || h.body_b != sources.body().b())
        throw Error(ErrorCode::usage, "the file and the sources are placed on different bodies");
    std::optional<tbb::global_control> threads;
    if (options.threads > 0)
        threads.emplace(tbb::global_control::max_allowed_parallelism,
                        static_cast<std::size_t>(options.threads));
    const FileSurface surface(std::move(file), options.memory_bytes);
    std::uint64_t total = 0;
    for (const LayerInfo& layer : sources.layers()) total += layer.samples;
    Progress progress(options, total);
    return measure_blocks(sources, surface, options.worst_places, [&](std::uint64_t n) { progress.step(n); });
}

}  // namespace carat
