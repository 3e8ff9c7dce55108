#include "update_closure.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace carat {
namespace {

constexpr int kLook = 6;  // levels between a patch and the surface it is compared with

std::vector<std::size_t> first_of_levels(const RefinedLevels& levels) {
    std::vector<std::size_t> first{0};
    for (const auto& level : levels) first.push_back(first.back() + level.size());
    return first;
}

bool same_half(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b, int n, int side) {
    for (int i = 0; i < n; ++i) {
        const std::ptrdiff_t row = static_cast<std::ptrdiff_t>(i) * n;
        const int begin = side == 0 ? 0 : i, end = side == 0 ? i + 1 : n;
        if (!std::equal(a.begin() + row + begin, a.begin() + row + end, b.begin() + row + begin))
            return false;
    }
    return true;
}

// Summary of one half, from what lies beneath it.
class HalfSummariser {
  public:
    // summary_of(half, level): of a refined half one to six levels below.
    using SummaryOf = std::function<const SummaryValues*(const Half&, int level)>;

    HalfSummariser(const OutputJob& job, DecodedHeights& heights, SummaryOf summary_of)
        : job_(job), heights_(heights), summary_of_(std::move(summary_of)) {}

    SummaryValues operator()(const Half& own) {
        own_ = own;
        n_ = (1 << job_.options.log2_cells) + 1;
        const RefinedPtr refined = heights_.refined(own.diamond);
        vertices_ = &refined->v;  // mode 0: V = P
        const HeightRange range = height_range(vertices_->data(), n_, own.side);
        flat_ = flat_patch_bound(job_.options.body, own, range, job_.quantum, n_ - 1);
        out_ = {range.min, range.max, 0};
        descend(own, own.diamond.level(), *refined, 1);
        return out_;
    }

  private:
    void descend(const Half& half, int level, const RefinedHeights& refined, int depth) {
        for (const Half& child : child_halves(half)) {
            const SummaryValues* there = summary_of_(child, level + 1);
            SummaryValues leaf;
            if (there == nullptr || depth == kLook) {
                child_.resize(static_cast<std::size_t>(n_ * n_));
                gather_half(refined, half.diamond, child, child_.data());
            }
            if (there == nullptr) leaf = summary_of_leaf(child);
            const SummaryValues& s = there != nullptr ? *there : leaf;
            if (depth == 1) include(s);
            if (there == nullptr || depth == kLook) {
                const auto dev =
                    static_cast<double>(max_deviation(vertices_->data(), own_, child_.data(), child, n_)) / 8;
                out_.delta = std::max(out_.delta, flat_ + job_.quantum * dev + s.delta);
            } else {
                descend(child, level + 1, *heights_.refined(child.diamond), depth + 1);
            }
        }
    }
    void include(const SummaryValues& s) {
        out_.min = std::min(out_.min, s.min);
        out_.max = std::max(out_.max, s.max);
        out_.delta = std::max(out_.delta, s.delta);
    }
    SummaryValues summary_of_leaf(const Half& leaf) const {
        const HeightRange range = height_range(child_.data(), n_, leaf.side);
        return {range.min, range.max, flat_patch_bound(job_.options.body, leaf, range, job_.quantum, n_ - 1)};
    }

    const OutputJob& job_;
    DecodedHeights& heights_;
    SummaryOf summary_of_;
    int n_ = 0;
    Half own_;
    const std::vector<std::int32_t>* vertices_ = nullptr;
    double flat_ = 0;
    std::vector<std::int32_t> child_;
    SummaryValues out_;
};

}  // namespace

UpdateClosure::UpdateClosure(const OutputJob& job, const UpdateState& state,
                             std::function<bool(DiamondId)> touched, std::size_t memory)
    : job_(job),
      state_(state),
      touched_(std::move(touched)),
      memory_(memory),
      n_((1 << job.options.log2_cells) + 1),
      grid_(job.options.body.a(), job.quantum, job.options.log2_cells),
      first_(first_of_levels(state.plan.levels)),
      first_before_(first_of_levels(state.levels_before)),
      old_(state.roots_before, n_, memory / 2,
           [this](DiamondId d, const std::vector<std::int32_t>& p, RefinedHeights& out) {
               state_.file.refine(d, {n_, p, {true, true}}, out);
           }),
      new_(
          state.roots, n_, memory / 2,
          [this](DiamondId d, const std::vector<std::int32_t>& p, RefinedHeights& out) {
              thread_local CodecScratch scratch;
              const std::size_t k = index_of(d, d.level());
              decode_residuals(job_.options.coding, diamonds_[k].info, blobs_[k], p, n_, job_.radius, out,
                               scratch);
          },
          [this](DiamondId d) { return changed(d) ? nullptr : old_.refined(d); }) {
    diamonds_.resize(first_.back());
    before_.resize(first_.back(), kNone);
    fate_.resize(first_.back(), Fate::kept);
    blobs_.resize(first_.back());
    stale_.resize(first_.back());
    stale_halves_.resize(state.plan.levels.size());
    for (std::size_t level = 0; level < state.plan.levels.size(); ++level) match(level);
}

// Both lists of a level are in the order of ids.
void UpdateClosure::match(std::size_t level) {
    const std::vector<DiamondId>& now = state_.plan.levels[level];
    static const std::vector<DiamondId> kNothing;
    const std::vector<DiamondId>& then =
        level < state_.levels_before.size() ? state_.levels_before[level] : kNothing;
    std::size_t old = 0;
    for (std::size_t position = 0; position < now.size(); ++position) {
        const std::size_t k = first_[level] + position;
        diamonds_[k].id = now[position];
        while (old < then.size() && then[old] < now[position]) ++old;
        if (old == then.size() || then[old] != now[position]) continue;
        before_[k] = first_before_[level] + old;
        diamonds_[k] = state_.before.diamonds()[before_[k]];
    }
}

std::size_t UpdateClosure::index_of(DiamondId d, int level) const {
    const auto at = position_of(state_.plan.levels, d, level);
    return at ? first_[static_cast<std::size_t>(level)] + *at : kNone;
}

bool UpdateClosure::changed(DiamondId d) const { return fate_[index_of(d, d.level())] == Fate::changed; }

void UpdateClosure::blob(std::size_t index, std::vector<std::byte>& out) const {
    if (fate_[index] == Fate::changed)
        out = blobs_[index];
    else
        state_.before.blob(before_[index], out);
}

bool UpdateClosure::unchanged(std::size_t index) const {
    if (before_[index] == kNone || fate_[index] == Fate::changed) return false;
    const DiamondEntry& then = state_.before.diamonds()[before_[index]];
    return then.summary == diamonds_[index].summary;
}

std::vector<std::size_t> UpdateClosure::looked_at() const {
    std::vector<std::size_t> out;
    for (const auto& level : work_) out.insert(out.end(), level.begin(), level.end());
    return out;
}

// The near, and children of those whose heights changed.
std::vector<std::size_t> UpdateClosure::candidates(std::size_t level) const {
    std::vector<std::size_t> out;
    const auto add = [&](DiamondId d) {
        if (const std::size_t k = index_of(d, static_cast<int>(level)); k != kNone) out.push_back(k);
    };
    if (level < state_.plan.near.size())
        for (const DiamondId d : state_.plan.near[level]) add(d);
    if (level == 0)
        for (int face = 0; face < kFaces; ++face) add(root_diamond(face));
    else
        for (const std::size_t up : work_[level - 1])
            if (fate_[up] == Fate::changed)
                for (const DiamondId d : children(diamonds_[up].id)) add(d);
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
}

void UpdateClosure::code() {
    for (std::size_t level = 0; level < state_.plan.levels.size(); ++level) {
        const std::vector<std::size_t>& work = work_.emplace_back(candidates(level));
        tbb::parallel_for(std::size_t{0}, work.size(), [&](std::size_t k) {
            code_one(static_cast<int>(level), work[k]);
            job_.progress.step();
        });
        job_.progress.step(state_.plan.levels[level].size() - work.size());
    }
}

// Of a diamond that was refined before, so that both its parents were.
bool UpdateClosure::vertices_changed(DiamondId d, int level) {
    if (level == 0) {
        const auto face = static_cast<std::size_t>(d.face());
        return state_.roots[face] != state_.roots_before[face];
    }
    thread_local std::vector<std::int32_t> before, now;
    for (const int side : {0, 1}) {
        if (!changed(*parent(d, side))) continue;
        old_.vertices(Half{d, side}, before);
        new_.vertices(Half{d, side}, now);
        if (!same_half(before, now, n_, side)) return true;
    }
    return false;
}

void UpdateClosure::code_one(int level, std::size_t k) {
    DiamondEntry& entry = diamonds_[k];
    const DiamondId d = entry.id;
    const bool was_there = before_[k] != kNone, same_vertices = was_there && !vertices_changed(d, level);
    if (same_vertices && !touched_(d)) return;
    recoded_.fetch_add(1, std::memory_order_relaxed);
    thread_local std::vector<std::int32_t> p;
    thread_local RefinedHeights reference;
    thread_local CodecScratch scratch;
    new_.vertices(d, p);
    sample_reference(job_.sources, job_.quantum, n_, d, reference);
    reference.v = p;
    auto refined = std::make_shared<RefinedHeights>();
    EncodedResiduals residuals = encode_residuals(job_.options.coding, Mode::interpolating, p, reference,
                                                  job_.radius, *refined, scratch);
    if (same_vertices && residuals.info == entry.info && residuals.blob.size() == entry.blob_bytes) {
        thread_local std::vector<std::byte> before;
        state_.before.blob(before_[k], before);
        if (before == residuals.blob) {
            fate_[k] = Fate::coded_alike;
            return;
        }
    }
    entry.info = residuals.info;
    entry.blob_bytes = residuals.blob.size();
    constexpr std::size_t kNode = 64;
    if (held_.fetch_add(residuals.blob.size() + kNode) > memory_) throw ClosureTooLarge{};
    blobs_[k] = std::move(residuals.blob);
    fate_[k] = Fate::changed;
    changed_.fetch_add(1, std::memory_order_relaxed);
    new_.remember(d, std::move(refined));
}

void UpdateClosure::mark_stale(std::size_t level, std::size_t index, int side) {
    std::uint8_t& stale = stale_[index][static_cast<std::size_t>(side)];
    if (stale != 0) return;
    stale = 1;
    stale_halves_[level].emplace_back(index, side);
}

// half: of a diamond of `level`.
void UpdateClosure::mark_stale_above(const Half& half, std::size_t level) {
    if (level == 0) return;
    const Half up = *parent_half(half);
    const std::size_t k = index_of(up.diamond, static_cast<int>(level) - 1);
    if (k != kNone) mark_stale(level - 1, k, up.side);
}

// A half is stale if its own heights changed, the refinement of a half of it did, or one of these is stale.
void UpdateClosure::find_stale() {
    const std::size_t depth = state_.plan.levels.size();
    for (const RefinedLevels* list : {&state_.plan.added, &state_.plan.removed})
        for (std::size_t level = 0; level < list->size() && level <= depth; ++level)
            for (const DiamondId d : (*list)[level])
                for (const int side : {0, 1}) mark_stale_above({d, side}, level);
    for (std::size_t level = depth; level-- > 0;) {
        for (const std::size_t k : work_[level])
            for (const int side : {0, 1})
                if (fate_[k] == Fate::changed) mark_stale(level, k, side);
        for (const auto& [k, side] : stale_halves_[level]) mark_stale_above({diamonds_[k].id, side}, level);
    }
}

// Of a half under a zero page the file does not tell the summary, only that of the whole page. If one of them
// is needed, all under the page are worked out anew.
void UpdateClosure::find_stale_zero_pages() {
    if (state_.before.zero_pages() == 0) return;
    while (mark_zero_pages_near_stale()) {
    }
}

bool UpdateClosure::mark_zero_pages_near_stale() {
    std::vector<std::uint8_t> wanted(state_.before.zero_pages());
    // Levels up to the nearest stale half that contains a half; what a stale half reads is at most kLook
    // below.
    std::vector<std::array<std::uint8_t, 2>> above(diamonds_.size());
    bool found = false;
    for (std::size_t level = 0; level < state_.plan.levels.size(); ++level)
        for (std::size_t k = first_[level]; k < first_[level + 1]; ++k)
            for (std::size_t side = 0; side < 2; ++side) {
                std::uint8_t& distance = above[k][side];
                distance = kLook + 1;
                if (level > 0) {
                    const Half up = *parent_half({diamonds_[k].id, static_cast<int>(side)});
                    const std::size_t u = index_of(up.diamond, static_cast<int>(level) - 1);
                    const int further = above[u][static_cast<std::size_t>(up.side)] + 1;
                    distance = static_cast<std::uint8_t>(std::min(further, kLook + 1));
                }
                if (stale_[k][side] != 0) distance = 0;
                const std::int32_t page = before_[k] == kNone ? -1 : state_.before.zero_page(before_[k]);
                if (page >= 0 && distance <= kLook) wanted[static_cast<std::size_t>(page)] = 1;
            }
    for (std::size_t level = 0; level < state_.plan.levels.size(); ++level)
        for (std::size_t k = first_[level]; k < first_[level + 1]; ++k) {
            const std::int32_t page = before_[k] == kNone ? -1 : state_.before.zero_page(before_[k]);
            if (page < 0 || wanted[static_cast<std::size_t>(page)] == 0) continue;
            for (const int side : {0, 1}) {
                found = found || stale_[k][static_cast<std::size_t>(side)] == 0;
                mark_stale(level, k, side);
            }
        }
    return found;
}

void UpdateClosure::summarise_half(int level, std::size_t k, int side) {
    const auto summary_of = [&](const Half& half, int at) -> const SummaryValues* {
        const std::size_t c = index_of(half.diamond, at);
        return c == kNone ? nullptr : &diamonds_[c].summary[static_cast<std::size_t>(half.side)];
    };
    const SummaryValues exact = HalfSummariser(job_, new_, summary_of)({diamonds_[k].id, side});
    diamonds_[k].summary[static_cast<std::size_t>(side)] = grid_.rounded(exact, level);
    summaries_.fetch_add(1, std::memory_order_relaxed);
}

void UpdateClosure::summarise() {
    find_stale();
    find_stale_zero_pages();
    for (std::size_t level = state_.plan.levels.size(); level-- > 0;) {
        const auto& halves = stale_halves_[level];
        tbb::parallel_for(std::size_t{0}, halves.size(), [&](std::size_t k) {
            summarise_half(static_cast<int>(level), halves[k].first, halves[k].second);
        });
        job_.progress.step(state_.plan.levels[level].size());
    }
}

}  // namespace carat
