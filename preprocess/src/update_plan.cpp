#include "update_plan.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <iterator>

#include "build_plan.hpp"

namespace carat {
namespace {

using Ids = std::vector<DiamondId>;

bool contains(const Ids& ids, DiamondId d) { return std::binary_search(ids.begin(), ids.end(), d); }

const Ids& level_of(const RefinedLevels& levels, std::size_t level) {
    static const Ids kNothing;
    return level < levels.size() ? levels[level] : kNothing;
}

void sort_unique(Ids& ids) {
    std::sort(ids.begin(), ids.end());
    ids.erase(std::unique(ids.begin(), ids.end()), ids.end());
}

Ids difference(const Ids& a, const Ids& b) {
    Ids out;
    std::set_difference(a.begin(), a.end(), b.begin(), b.end(), std::back_inserter(out));
    return out;
}

RefinedLevels difference(const RefinedLevels& a, const RefinedLevels& b) {
    RefinedLevels out;
    for (std::size_t level = 0; level < a.size(); ++level)
        out.push_back(difference(a[level], level_of(b, level)));
    return out;
}

// A diamond out of the layer's reach and all below it are as deep as they were.
class Replanning {
  public:
    Replanning(const BuildOptions& options, const SourceStack& sources, std::size_t layer,
               const RefinedLevels& before, ProgressReporter& progress)
        : options_(options), sources_(sources), layer_(layer), before_(before), progress_(progress) {}

    UpdatePlan run() {
        find_near();
        find_kept();
        choose();
        UpdatePlan out;
        out.near = std::move(wanted_);
        for (std::size_t level = 0; level < std::max(before_.size(), out.near.size()); ++level) {
            const Ids far = difference(level_of(before_, level), level_of(near_, level));
            Ids& all = out.levels.emplace_back();
            const Ids& near = level_of(out.near, level);
            std::set_union(far.begin(), far.end(), near.begin(), near.end(), std::back_inserter(all));
        }
        while (!out.levels.empty() && out.levels.back().empty()) out.levels.pop_back();
        return out;
    }

  private:
    bool was_refined(DiamondId d, std::size_t level) const { return contains(level_of(before_, level), d); }
    // Refined before, and the layer may have no say in it.
    bool is_far(DiamondId d, std::size_t level) const {
        return was_refined(d, level) && !contains(level_of(near_, level), d);
    }

    // Of the diamonds before, those in the layer's reach whose parents are in it too.
    void find_near() {
        for (std::size_t level = 0; level < before_.size(); ++level) {
            Ids candidates, found;
            if (level == 0)
                candidates = before_[0];
            else
                for (const DiamondId up : near_[level - 1])
                    for (const DiamondId d : children(up)) candidates.push_back(d);
            sort_unique(candidates);
            std::vector<std::uint8_t> near(candidates.size());
            tbb::parallel_for(std::size_t{0}, candidates.size(), [&](std::size_t k) {
                const DiamondId d = candidates[k];
                near[k] = was_refined(d, level) && parents_near(d, level) && sources_.may_reach(layer_, d);
            });
            for (std::size_t k = 0; k < candidates.size(); ++k)
                if (near[k] != 0) found.push_back(candidates[k]);
            near_.push_back(std::move(found));
        }
    }
    bool parents_near(DiamondId d, std::size_t level) const {
        return level == 0 ||
               (contains(near_[level - 1], *parent(d, 0)) && contains(near_[level - 1], *parent(d, 1)));
    }

    // Of the near, those that a far one below them demands.
    void find_kept() {
        kept_.resize(near_.size());
        for (std::size_t level = near_.size(); level-- > 0;)
            for (const DiamondId d : near_[level])
                for (const DiamondId c : children(d))
                    if (is_far(c, level + 1) || contains(level_of(kept_, level + 1), c)) {
                        kept_[level].push_back(d);
                        break;
                    }
    }

    void choose() {
        const int end_level = end_of_levels(options_);
        Ids candidates;
        for (int face = 0; face < kFaces; ++face) candidates.push_back(root_diamond(face));
        for (int l = 0; l < end_level && !candidates.empty(); ++l) {
            const auto level = static_cast<std::size_t>(l);
            Ids wanted = level_of(kept_, level), asked;
            for (const DiamondId d : candidates)
                if (!contains(level_of(kept_, level), d) && has_say(d, level)) asked.push_back(d);
            asked = too_coarse(asked, options_, sources_, progress_);
            wanted.insert(wanted.end(), asked.begin(), asked.end());
            std::sort(wanted.begin(), wanted.end());
            candidates.clear();
            for (const DiamondId d : wanted)
                for (const DiamondId c : children(d)) candidates.push_back(c);
            sort_unique(candidates);
            wanted_.push_back(std::move(wanted));
        }
        for (std::size_t level = wanted_.size(); level-- > 1;) {
            Ids& above = wanted_[level - 1];
            for (const DiamondId d : wanted_[level])
                for (const int side : {0, 1}) above.push_back(*parent(d, side));
            sort_unique(above);
        }
    }
    bool has_say(DiamondId d, std::size_t level) const {
        if (was_refined(d, level)) return contains(near_[level], d);
        for (const int side : {0, 1})
            if (level > 0 && is_far(*parent(d, side), level - 1)) return false;
        return sources_.may_reach(layer_, d);
    }

    const BuildOptions& options_;
    const SourceStack& sources_;
    std::size_t layer_;
    const RefinedLevels& before_;
    ProgressReporter& progress_;
    RefinedLevels near_, kept_, wanted_;
};

}  // namespace

UpdatePlan plan_update(const BuildOptions& options, const SourceStack& sources, std::size_t layer,
                       const RefinedLevels& before, ProgressReporter& progress) {
    UpdatePlan out = Replanning(options, sources, layer, before, progress).run();
    out.added = difference(out.levels, before);
    out.removed = difference(before, out.levels);
    return out;
}

UpdatePlan whole_update(RefinedLevels levels, const RefinedLevels& before) {
    UpdatePlan out{std::move(levels), {}, {}, {}};
    out.near = out.levels;
    out.added = difference(out.levels, before);
    out.removed = difference(before, out.levels);
    return out;
}

}  // namespace carat
