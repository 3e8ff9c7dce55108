#include "build_estimate.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <ctime>

#include "build_passes.hpp"
#include "build_trial.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/preprocess/provenance.hpp"

namespace carat {
namespace {

constexpr std::uint64_t kIndexBytes = 10;  // of a diamond in a page besides its residuals, directory included
// Of a build's time once it is planned, by what the samples show, measured (docs/benchmarks.md): summaries,
// temporary files and writing in units of coding; sources read once, and compared once, samples a second and
// thread; PROJ asked for the place of a sample of a projected layer, which comparing does, seconds.
constexpr double kBesidesCoding = 2.2, kReadRate = 60e6, kMeasureRate = 9e6, kInverse = 1.1e-6;

// Processor time of this thread, so that other programs do not count.
double thread_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

double measuring_seconds(const BuildPlan& plan) {
    double seconds = 0;
    for (const LayerInfo& layer : plan.layers) {
        const bool projected = std::any_of(layer.files.begin(), layer.files.end(),
                                           [](const FileInfo& f) { return !f.transformation.empty(); });
        seconds += static_cast<double>(layer.valid_samples) * (1 / kMeasureRate + (projected ? kInverse : 0));
    }
    return seconds;
}

std::size_t root_bytes(const BuildOptions& options, const SourceStack& sources) {
    const double quantum = options.quantum.value_or(default_quantum(options.tolerance));
    const int n = (1 << options.log2_cells) + 1;
    FaceHeights faces;
    for (int face = 0; face < kFaces; ++face)
        faces[static_cast<std::size_t>(face)] = sample_face(sources, quantum, n, face);
    return encode_roots(faces, n, quantizer_radius(options.tolerance, quantum)).bytes.size();
}

std::uint64_t leaf_halves(const RefinedLevels& levels) {
    std::uint64_t refined = 0;
    for (const auto& level : levels) refined += level.size();
    return 2 * (kFaces + refined);  // each refinement turns two halves into four
}

}  // namespace

std::size_t trials_before_build(const BuildPlan& plan) {
    return std::clamp<std::size_t>(plan.refined / 48, 16, kMostTrials);
}

BuildEstimate estimate_build(const BuildOptions& options, const SourceStack& sources,
                             const RefinedLevels& levels, const BuildPlan& plan, std::size_t trials) {
    BuildEstimate out;
    const std::vector<DiamondId> some = spread_diamonds(levels, trials);
    out.sampled = some.size();
    struct Cost {
        std::size_t bytes = 0;
        double sampling = 0, coding = 0;  // seconds: of one half, of the diamond
    };
    std::vector<Cost> costs(out.sampled);
    const std::int32_t radius =
        quantizer_radius(options.tolerance, options.quantum.value_or(default_quantum(options.tolerance)));
    tbb::parallel_for(std::size_t{0}, out.sampled, [&](std::size_t k) {
        const auto trial = std::make_unique<Trial>(options, sources);
        trial->take(some[k]);  // brings the sources into memory
        double start = thread_seconds();
        trial->take(some[k]);
        costs[k].sampling = (thread_seconds() - start) / 4;
        start = thread_seconds();
        costs[k].bytes = trial->code(options.coding, radius, nullptr).bytes;
        costs[k].coding = thread_seconds() - start;
    });
    Cost sum;
    for (const Cost& c : costs) {
        sum.bytes += c.bytes;
        sum.sampling += c.sampling;
        sum.coding += c.coding;
    }
    const double scale = out.sampled == 0 ? 0 : 1 / static_cast<double>(out.sampled);
    const auto diamonds = static_cast<double>(plan.refined),
               samples = static_cast<double>(plan.source_samples);
    std::size_t header = provenance_json(options, plan).size();
    if (options.measures()) header = measured_room(provenance_json(options, plan), plan);
    out.file_bytes = static_cast<std::uint64_t>(diamonds * scale * static_cast<double>(sum.bytes)) +
                     kIndexBytes * plan.refined + root_bytes(options, sources) + header;
    const double work = static_cast<double>(leaf_halves(levels)) * scale * sum.sampling +
                        diamonds * scale * sum.coding * kBesidesCoding + samples / kReadRate +
                        (options.measures() ? measuring_seconds(plan) : 0);
    out.seconds = work / std::max(1, tbb::this_task_arena::max_concurrency());
    return out;
}

}  // namespace carat
