#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include <algorithm>

#include "build_passes.hpp"

namespace carat {
namespace {

constexpr int kLook = 6;  // levels between a patch and the surface it is compared with

class HalfSummarizer {
  public:
    HalfSummarizer(const BuildContext& context, const BuildTree& tree, std::vector<std::int32_t>& scratch)
        : context_(context), tree_(tree), scratch_(scratch) {}

    // delta(h) = max(delta of its children, max over the halves g six levels finer, or leaves, of
    //                dev(h, g) + delta(g)); dev is the curvature bound of h's triangles plus the height
    //                difference.
    SummaryValues operator()(const BuildDiamond& d, int side) {
        half_ = {d.id, side};
        p_ = d.p.data();
        const HeightRange own = height_range(p_, context_.n(), side);
        flat_ = bound(half_, own);
        result_ = {own.min, own.max, 0};
        visit(half_, 0);
        return result_;
    }

  private:
    double bound(const Half& h, const HeightRange& range) const {
        return flat_patch_bound(context_.options.body, h, range, context_.quantum, context_.n() - 1);
    }
    void visit(const Half& g, int depth) {
        const BuildDiamond* refined = tree_.find(g.diamond);
        if (refined != nullptr && depth == 1) include(refined->summary[static_cast<std::size_t>(g.side)]);
        if (refined != nullptr && depth < kLook) {
            for (const Half& child : child_halves(g)) visit(child, depth + 1);
            return;
        }
        const std::int32_t* fine = half_heights(tree_, g, context_.n(), scratch_);
        const SummaryValues there =
            refined != nullptr ? refined->summary[static_cast<std::size_t>(g.side)] : leaf(g, fine);
        include(there);
        const double dev = static_cast<double>(max_deviation(p_, half_, fine, g, context_.n())) / 8;
        result_.delta = std::max(result_.delta, flat_ + context_.quantum * dev + there.delta);
    }
    SummaryValues leaf(const Half& g, const std::int32_t* p) const {
        const HeightRange range = height_range(p, context_.n(), g.side);
        return {range.min, range.max, bound(g, range)};
    }
    void include(const SummaryValues& s) {
        result_.min = std::min(result_.min, s.min);
        result_.max = std::max(result_.max, s.max);
        result_.delta = std::max(result_.delta, s.delta);
    }

    const BuildContext& context_;
    const BuildTree& tree_;
    std::vector<std::int32_t>& scratch_;
    Half half_;
    const std::int32_t* p_ = nullptr;
    double flat_ = 0;
    SummaryValues result_;
};

}  // namespace

void summarise_tree(const BuildContext& context, BuildTree& tree) {
    tbb::enumerable_thread_specific<std::vector<std::int32_t>> scratch;
    for (int level = tree.depth(); level-- > 0;) {
        auto& diamonds = tree.levels[static_cast<std::size_t>(level)];
        tbb::parallel_for(std::size_t{0}, diamonds.size(), [&](std::size_t k) {
            HalfSummarizer summarize(context, tree, scratch.local());
            for (const int side : {0, 1})
                diamonds[k].summary[static_cast<std::size_t>(side)] = summarize(diamonds[k], side);
            context.progress.step();
        });
    }
}

}  // namespace carat
