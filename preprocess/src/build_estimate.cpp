#include "build_estimate.hpp"

#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "build_passes.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/patch.hpp"
#include "carat/preprocess/provenance.hpp"

namespace carat {
namespace {

constexpr std::size_t kSampled = 192;      // diamonds
constexpr std::uint64_t kIndexBytes = 10;  // of a diamond in a page besides its residuals, directory included
// Of a build's time by what the samples show, measured (docs/benchmarks.md): summaries, temporary files and
// writing in units of coding; sources read once, and compared once, samples a second and thread.
constexpr double kBesidesCoding = 2.2, kReadRate = 60e6, kMeasureRate = 9e6;

using Clock = std::chrono::steady_clock;
double seconds_since(Clock::time_point t) { return std::chrono::duration<double>(Clock::now() - t).count(); }

// One diamond coded from source heights, its vertices rounded as a quantiser would.
class Trial {
  public:
    Trial(const BuildOptions& options, const SourceStack& sources)
        : options_(options),
          sources_(sources),
          n_((1 << options.log2_cells) + 1),
          quantum_(options.quantum.value_or(default_quantum(options.tolerance))),
          radius_(quantizer_radius(options.tolerance, quantum_)) {}

    struct Cost {
        std::size_t bytes = 0;
        double sampling = 0, coding = 0;  // seconds: of one half, of the diamond
    };
    Cost operator()(DiamondId d) {
        for (const int side : {0, 1}) take({d, side}, d);  // brings the sources into memory
        Cost out;
        auto start = Clock::now();
        for (const int side : {0, 1})
            for (const Half& child : child_halves({d, side})) take(child, d);
        out.sampling = seconds_since(start) / 4;
        start = Clock::now();
        const std::int32_t step = 2 * radius_ + 1;
        p_.resize(reference_.v.size());
        for (std::size_t k = 0; k < p_.size(); ++k)
            p_[k] =
                step * static_cast<std::int32_t>(std::lround(static_cast<double>(reference_.v[k]) / step));
        out.bytes =
            encode_residuals(options_.coding, options_.mode, p_, reference_, radius_, refined_, scratch_)
                .blob.size();
        out.coding = seconds_since(start);
        return out;
    }

  private:
    void take(const Half& half, DiamondId d) {
        heights_.resize(half_vertex_count(n_ - 1));
        sources_.sample(half, n_ - 1, heights_);
        reference_.n = n_;
        reference_.v.resize(static_cast<std::size_t>(n_ * n_));
        reference_.c.resize(static_cast<std::size_t>((n_ - 1) * (n_ - 1)));
        if (half.diamond == d) return;
        const ChildMap m = child_map(d, half, n_ - 1);
        const double* next = heights_.data();
        for (int i = 0; i < n_; ++i)
            for (int j = half.side == 0 ? 0 : i; j < (half.side == 0 ? i + 1 : n_); ++j) {
                const int p = m.p0 + i * m.pi + j * m.pj, q = m.q0 + i * m.qi + j * m.qj;
                const double scaled =
                    std::clamp(*next++ / quantum_, -1.0 * kGreatestHeight, 1.0 * kGreatestHeight);
                auto& to = (p & 1) == 0
                               ? reference_.v[static_cast<std::size_t>((p >> 1) * n_ + (q >> 1))]
                               : reference_.c[static_cast<std::size_t>((p >> 1) * (n_ - 1) + (q >> 1))];
                to = static_cast<std::int32_t>(std::lround(scaled));
            }
    }

    const BuildOptions& options_;
    const SourceStack& sources_;
    int n_;
    double quantum_;
    std::int32_t radius_;
    std::vector<double> heights_;
    std::vector<std::int32_t> p_;
    RefinedHeights reference_, refined_;
    CodecScratch scratch_;
};

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

BuildEstimate estimate_build(const BuildOptions& options, const SourceStack& sources,
                             const RefinedLevels& levels, const BuildPlan& plan) {
    BuildEstimate out;
    std::vector<DiamondId> all;
    for (const auto& level : levels) all.insert(all.end(), level.begin(), level.end());
    out.sampled = std::min(kSampled, all.size());
    std::vector<Trial::Cost> costs(out.sampled);
    tbb::parallel_for(std::size_t{0}, out.sampled, [&](std::size_t k) {
        costs[k] = Trial(options, sources)(all[(2 * k + 1) * all.size() / (2 * out.sampled)]);
    });
    Trial::Cost sum;
    for (const Trial::Cost& c : costs) {
        sum.bytes += c.bytes;
        sum.sampling += c.sampling;
        sum.coding += c.coding;
    }
    const double scale = out.sampled == 0 ? 0 : 1 / static_cast<double>(out.sampled);
    const auto diamonds = static_cast<double>(all.size()), samples = static_cast<double>(plan.source_samples);
    std::size_t header = provenance_json(options, plan).size();
    if (options.measures()) header = measured_room(provenance_json(options, plan), plan);
    out.file_bytes = static_cast<std::uint64_t>(diamonds * scale * static_cast<double>(sum.bytes)) +
                     kIndexBytes * all.size() + root_bytes(options, sources) + header;
    const double work = static_cast<double>(leaf_halves(levels)) * scale * sum.sampling +
                        diamonds * scale * sum.coding * kBesidesCoding + samples / kReadRate +
                        (options.measures() ? samples / kMeasureRate : 0);
    out.seconds = work / std::max(1, tbb::this_task_arena::max_concurrency());
    return out;
}

}  // namespace carat
