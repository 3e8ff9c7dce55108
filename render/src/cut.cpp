#include "carat/render/cut.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "carat/globe/error.hpp"
#include "cut_graph.hpp"
#include "half_bounds.hpp"
#include "stopwatch.hpp"

namespace carat {
namespace {

ReadCounters difference(const ReadCounters& after, const ReadCounters& before) {
    return {after.pages - before.pages, after.bytes - before.bytes,
            after.diamonds_decoded - before.diamonds_decoded, after.diamonds_zero - before.diamonds_zero};
}

enum class Outcome : std::uint8_t {
    moot,     // its diamond is refined already
    settled,  // culled, or within the threshold
    demands,  // refinement
    waits,    // for its heights
};

class Selection {
  public:
    Selection(const Repository& repository, const Visibility& visibility, double threshold, double spacing,
              const ColourRepository* colour, const Detail* detail)
        : repository_(repository),
          detail_(detail),
          visibility_(visibility),
          threshold_(threshold),
          spacing_(spacing),
          cells_(repository.header().cells()),
          deepest_(deepest_refinable_level(repository.header().log2_cells)),
          survey_(repository, visibility.body(), colour, detail),
          graph_(repository) {}

    Cut run() {
        std::vector<CutHalf*> pending = graph_.take_new_halves();
        decode_roots();
        while (!pending.empty()) {
            std::vector<CutHalf*> waiting;
            {
                const Stopwatch watch(counters_.selection_ms);
                select(std::move(pending), waiting);
            }
            const Stopwatch watch(counters_.decode_ms);
            decode(graph_.take_new_refined());
            pending = std::move(waiting);
        }
        return result();
    }

  private:
    // Judges halves and refines what they demand until only those wait whose heights are not decoded yet.
    void select(std::vector<CutHalf*> pending, std::vector<CutHalf*>& waiting) {
        std::vector<Outcome> outcomes;
        while (!pending.empty()) {
            outcomes.assign(pending.size(), Outcome::moot);
            tbb::parallel_for(std::size_t{0}, pending.size(), [&](std::size_t k) {
                if (!pending[k]->node->refined) outcomes[k] = judge(*pending[k]);
            });
            for (std::size_t k = 0; k < pending.size(); ++k) {
                if (outcomes[k] == Outcome::settled || outcomes[k] == Outcome::demands) count(*pending[k]);
                if (outcomes[k] == Outcome::demands) graph_.refine(*pending[k]->node);
                if (outcomes[k] == Outcome::waits) waiting.push_back(pending[k]);
            }
            check_limit();
            pending = graph_.take_new_halves();
        }
    }

    void check_limit() const {
        if (graph_.refined() > kMaxRefined)
            throw Error(ErrorCode::limit, "the view needs more than " + std::to_string(kMaxRefined) +
                                              " diamonds refined; allow a greater error on screen");
    }

    Outcome judge(CutHalf& h) const {
        const Half half = h.half();
        if (h.in_file) {
            const bool demands = judge(h, survey_.by_summary(half, h.node->in_file));
            if (!demands || h.node->in_file) return demands ? Outcome::demands : Outcome::settled;
        }
        if (h.heights.empty()) return Outcome::waits;
        const bool demands = judge(h, survey_.by_heights(half, h.heights));
        return demands && h.node->level < deepest_ ? Outcome::demands : Outcome::settled;
    }

    bool judge(CutHalf& h, const HalfBounds& bounds) const {
        const Judgement j = carat::judge(visibility_, threshold_, spacing_, bounds);
        h.culled = j.culled;
        h.error = j.error;
        h.delta = bounds.delta;
        return j.demands;
    }

    void count(const CutHalf& h) {
        ++counters_.halves_tested;
        if (h.culled == Culled::frustum) ++counters_.culled_frustum;
        if (h.culled == Culled::horizon) ++counters_.culled_horizon;
    }

    void decode_roots() {
        const Stopwatch watch(counters_.decode_ms);
        for (int face = 0; face < kFaces; ++face) {
            std::array<HalfHeights, 2> heights = split(repository_.root(face));
            CutNode& root = *graph_.nodes().at(root_diamond(face));
            for (const std::size_t side : {0u, 1u}) {
                CutHalf& half = root.halves[side];
                half.heights = std::move(heights[side]);
                if (detail_ != nullptr && !root.in_file)
                    detail_->begin(repository_, half.half(), half.heights);
            }
        }
    }

    // Parents first; the diamonds of a level are independent of each other.
    void decode(std::vector<CutNode*> nodes) {
        std::sort(nodes.begin(), nodes.end(), [](const CutNode* l, const CutNode* r) {
            return std::pair(l->level, l->id) < std::pair(r->level, r->id);
        });
        for (auto level = nodes.begin(); level != nodes.end();) {
            const auto next = std::find_if(level, nodes.end(),
                                           [&](const CutNode* n) { return n->level != (*level)->level; });
            tbb::parallel_for(std::size_t{0}, static_cast<std::size_t>(next - level),
                              [&](std::size_t k) { decode(*level[static_cast<std::ptrdiff_t>(k)]); });
            level = next;
        }
    }

    // Hands the refined heights to the four child halves and lets go of its own.
    void decode(CutNode& n) const {
        const auto hand_down = [&](const auto& refined) {
            for (CutHalf* child : n.child_halves) {
                child->heights = gather_child(refined, n.id, child->half());
                if (detail_ != nullptr && n.in_file && !child->node->in_file)
                    detail_->begin(repository_, child->half(), child->heights);
            }
        };
        if (n.in_file) {
            thread_local Heights whole;
            thread_local RefinedHeights refined;
            whole_heights(n.halves[0].heights, n.halves[1].heights, cells_, whole);
            repository_.refine(n.id, whole, refined);
            hand_down(refined);
        } else if (detail_ != nullptr) {
            thread_local VirtualHeights refined;
            detail_->refine(n.id, n.level, n.halves[0].heights, n.halves[1].heights, refined);
            hand_down(refined);
        } else {
            hand_down(refine_virtually(n.halves[0].heights, n.halves[1].heights, cells_));
        }
        for (CutHalf& h : n.halves) h.heights = {};
    }

    Cut result() {
        const Stopwatch watch(counters_.selection_ms);
        Cut cut;
        for (const auto& [id, node] : graph_.nodes()) {
            if (node->refined) {
                cut.refined.push_back(id);
                ++(node->in_file ? counters_.decoded : counters_.virtual_refined);
                continue;
            }
            for (CutHalf& h : node->halves)
                if (h.exists) cut.frontier.push_back(frontier_half(h));
        }
        std::sort(cut.refined.begin(), cut.refined.end());
        std::sort(cut.frontier.begin(), cut.frontier.end(),
                  [](const FrontierHalf& l, const FrontierHalf& r) { return l.half < r.half; });
        counters_.refined = cut.refined.size();
        counters_.triangles =
            counters_.patches * static_cast<std::uint64_t>(cells_) * static_cast<std::uint64_t>(cells_);
        cut.counters = counters_;
        return cut;
    }

    FrontierHalf frontier_half(CutHalf& h) {
        if (h.culled != Culled::none) return {h.half(), h.culled, !h.in_file, 0, 0, {}};
        ++counters_.patches;
        counters_.worst_error = std::max(counters_.worst_error, h.error);
        if (h.error > threshold_) ++counters_.limited;
        return {h.half(), Culled::none, !h.in_file, h.error, h.delta, std::move(h.heights)};
    }

    const Repository& repository_;
    const Detail* const detail_;
    const Visibility& visibility_;
    const double threshold_, spacing_;
    const int cells_, deepest_;
    const HalfSurvey survey_;
    CutGraph graph_;
    CutCounters counters_;
};

}  // namespace

int deepest_refinable_level(int p) { return std::min(deepest_level(p), kDeepestId) - 1; }

double leaf_delta(const CurvatureBound& curvature, const HalfRange& range) {
    return curvature.of_heights(std::max(std::abs(range.min), std::abs(range.max)), range.triangle_range);
}

double leaf_delta(const Ellipsoid& body, const Half& half, const HalfRange& range, int cells) {
    return leaf_delta(curvature_bound(body, half, cells), range);
}

Cut select_cut(const Repository& repository, const Visibility& visibility, double threshold, double spacing,
               const ColourRepository* colour, const Detail* detail) {
    if (!(threshold > 0)) throw Error(ErrorCode::usage, "the threshold on screen must be positive");
    if (!(spacing >= 0)) throw Error(ErrorCode::usage, "the spacing on screen must not be negative");
    const ReadCounters before = repository.counters();
    Cut cut = Selection(repository, visibility, threshold, spacing, colour, detail).run();
    cut.counters.read = difference(repository.counters(), before);
    return cut;
}

}  // namespace carat
