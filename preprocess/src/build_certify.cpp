#include "build_certify.hpp"

#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <unordered_set>

#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "leaf_surface.hpp"
#include "source_samples.hpp"

namespace carat {
namespace {

using DiamondSet = std::unordered_set<DiamondId, DiamondIdHash>;

// S0: the leaves of a planned refinement through source heights.
class PlannedSurface final : public LeafSurface {
  public:
    PlannedSurface(const DiamondSet& refined, const SourceStack& sources, int cells)
        : refined_(refined), sources_(sources), cells_(cells) {}

    int cells() const override { return cells_; }
    Half leaf(const RealLattice& place) const override {
        Half half = locate(place, 0).half;
        while (refined_.contains(half.diamond)) {
            const Location at = locate_in(place, half);
            half = child_halves(half)[at.s + at.t <= 1 ? 0 : 1];
        }
        return half;
    }
    void heights(const Half& leaf, std::vector<double>& out) const override {
        std::vector<double> heights(half_vertex_count(cells_));
        sources_.sample(leaf, cells_, heights);
        const double* next = heights.data();
        for (int i = 0; i <= cells_; ++i)
            for (int j = leaf.side == 0 ? 0 : i; j <= (leaf.side == 0 ? i : cells_); ++j)
                out[static_cast<std::size_t>(i * (cells_ + 1) + j)] = *next++;
    }

  private:
    const DiamondSet& refined_;
    const SourceStack& sources_;
    int cells_;
};

void sort_unique(std::vector<DiamondId>& ids) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

// What a block of samples says of the leaves it lies in.
struct BlockState {
    std::vector<DiamondId> leaves;   // that hold its compared samples
    std::vector<DiamondId> too_far;  // of these, those with a sample beyond the bound
    std::uint64_t samples = 0, beyond = 0;
    WorstPlace worst;
    double worst_error = 0;
};

class Certifier {
  public:
    Certifier(const BuildOptions& options, const SourceStack& sources, RefinedLevels& levels,
              ProgressReporter& progress)
        : options_(options),
          samples_(sources),
          levels_(levels),
          progress_(progress),
          bound_(*options.certify - options.tolerance),
          end_level_(std::min({options.max_level, deepest_level(options.log2_cells), kDeepestId})),
          surface_(refined_, sources, 1 << options.log2_cells),
          blocks_(samples_.blocks().size()) {
        for (const auto& level : levels) refined_.insert(level.begin(), level.end());
    }

    Certification run() {
        std::vector<std::size_t> stale(blocks_.size());
        for (std::size_t k = 0; k < stale.size(); ++k) stale[k] = k;
        Certification out;
        out.bound = *options_.certify;
        for (; !stale.empty(); ++out.rounds) {
            check(stale);
            const DiamondSet added = refine();
            out.added += added.size();
            stale = touched(added);
        }
        sum_up(out);
        rebuild_levels();
        return out;
    }

  private:
    void check(const std::vector<std::size_t>& stale) {
        std::uint64_t total = 0;
        for (const std::size_t k : stale) total += samples_in_block(k);
        progress_.begin(BuildStage::certifying, total);
        struct Worker {
            explicit Worker(const LeafSurface& s) : surface(s) {}
            BlockSamples samples;
            LeafEvaluator surface;
        };
        tbb::enumerable_thread_specific<Worker> workers([&] { return Worker(surface_); });
        tbb::parallel_for(std::size_t{0}, stale.size(), [&](std::size_t i) {
            Worker& w = workers.local();
            samples_.read(samples_.blocks()[stale[i]], w.samples);
            blocks_[stale[i]] = state_of(w.samples, w.surface);
            progress_.step(samples_in_block(stale[i]));
        });
    }

    std::uint64_t samples_in_block(std::size_t k) const {
        const PixelWindow& w = samples_.blocks()[k].window;
        return static_cast<std::uint64_t>(w.width) * static_cast<std::uint64_t>(w.height);
    }

    BlockState state_of(const BlockSamples& samples, LeafEvaluator& surface) const {
        constexpr double kRounding = 1e-9;  // metres: of S0 and of S, both evaluated in doubles
        BlockState out;
        for (std::size_t k = 0; k < samples.places.size(); ++k) {
            if (samples.blended[k] != 0) continue;
            ++out.samples;
            const double s = surface(samples.places[k]), error = std::abs(s - samples.heights[k]);
            const DiamondId leaf = surface.leaf().diamond;
            if (out.leaves.empty() || out.leaves.back() != leaf) out.leaves.push_back(leaf);
            if (error <= bound_ - kRounding) continue;
            ++out.beyond;
            if (out.too_far.empty() || out.too_far.back() != leaf) out.too_far.push_back(leaf);
            if (error <= out.worst_error) continue;
            out.worst_error = error;
            const Geodetic g = geodetic(direction(samples.places[k]));
            out.worst = {g.latitude, g.longitude, samples.heights[k], s};
        }
        sort_unique(out.leaves);
        sort_unique(out.too_far);
        return out;
    }

    // Refines the leaves that are too far off, where their depth allows it, and all ancestors of them that
    // are not refined yet.
    DiamondSet refine() {
        DiamondSet added;
        std::vector<DiamondId> open;
        for (const BlockState& b : blocks_)
            for (const DiamondId d : b.too_far)
                if (d.level() < end_level_) open.push_back(d);
        while (!open.empty()) {
            const DiamondId d = open.back();
            open.pop_back();
            if (!refined_.insert(d).second) continue;
            added.insert(d);
            if (d.level() > 0)
                for (const int side : {0, 1}) open.push_back(*parent(d, side));
        }
        return added;
    }

    std::vector<std::size_t> touched(const DiamondSet& added) const {
        std::vector<std::size_t> out;
        if (added.empty()) return out;
        for (std::size_t k = 0; k < blocks_.size(); ++k)
            if (std::any_of(blocks_[k].leaves.begin(), blocks_[k].leaves.end(),
                            [&](DiamondId d) { return added.contains(d); }))
                out.push_back(k);
        return out;
    }

    void sum_up(Certification& out) const {
        std::vector<const BlockState*> bad;
        for (const BlockState& b : blocks_) {
            out.samples += b.samples;
            out.beyond += b.beyond;
            if (b.beyond > 0) bad.push_back(&b);
        }
        std::stable_sort(bad.begin(), bad.end(),
                         [](const auto* a, const auto* b) { return a->worst_error > b->worst_error; });
        for (std::size_t k = 0; k < std::min(bad.size(), kListed); ++k) out.worst.push_back(bad[k]->worst);
    }

    void rebuild_levels() {
        levels_.clear();
        for (const DiamondId d : refined_) {
            if (levels_.size() <= static_cast<std::size_t>(d.level()))
                levels_.resize(static_cast<std::size_t>(d.level()) + 1);
            levels_[static_cast<std::size_t>(d.level())].push_back(d);
        }
        for (auto& level : levels_) std::sort(level.begin(), level.end());
    }

    static constexpr std::size_t kListed = 10;
    const BuildOptions& options_;
    SourceSamples samples_;
    RefinedLevels& levels_;
    ProgressReporter& progress_;
    double bound_;
    int end_level_;
    DiamondSet refined_;
    PlannedSurface surface_;
    std::vector<BlockState> blocks_;
};

}  // namespace

Certification certify_depth(const BuildOptions& options, const SourceStack& sources, RefinedLevels& levels,
                            ProgressReporter& progress) {
    return Certifier(options, sources, levels, progress).run();
}

}  // namespace carat
