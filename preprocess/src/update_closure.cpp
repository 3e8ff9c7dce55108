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
      first_(first_of_levels(state.levels)),
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
    for (std::size_t level = 0; level < state.levels.size(); ++level)
        tbb::parallel_for(std::size_t{0}, state.levels[level].size(), [&](std::size_t position) {
            const DiamondId d = state.levels[level][position];
            const std::size_t k = first_[level] + position;
            diamonds_[k].id = d;
            const auto at = position_of(state.levels_before, d, static_cast<int>(level));
            if (!at) return;
            before_[k] = first_before_[level] + *at;
            diamonds_[k] = state.before.diamonds()[before_[k]];
        });
}

std::size_t UpdateClosure::index_of(DiamondId d, int level) const {
    const auto at = position_of(state_.levels, d, level);
    return at ? first_[static_cast<std::size_t>(level)] + *at : kNone;
}

bool UpdateClosure::changed(DiamondId d) const { return fate_[index_of(d, d.level())] == Fate::changed; }

bool UpdateClosure::old_refined(DiamondId d, int level) const {
    return position_of(state_.levels_before, d, level).has_value();
}

void UpdateClosure::blob(std::size_t index, std::vector<std::byte>& out) const {
    if (fate_[index] == Fate::changed)
        out = blobs_[index];
    else
        state_.before.blob(before_[index], out);
}

void UpdateClosure::code() {
    for (std::size_t level = 0; level < state_.levels.size(); ++level)
        tbb::parallel_for(first_[level], first_[level + 1], [&](std::size_t k) {
            code_one(static_cast<int>(level), k);
            job_.progress.step();
        });
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

// A half is stale if its own heights changed, the refinement of a half of it did, or one of these is stale.
bool UpdateClosure::stale_half(int level, std::size_t k, int side) const {
    if (fate_[k] == Fate::changed) return true;
    for (const Half& child : child_halves({diamonds_[k].id, side})) {
        const std::size_t c = index_of(child.diamond, level + 1);
        if ((c != kNone) != old_refined(child.diamond, level + 1)) return true;
        if (c != kNone && stale_[c][static_cast<std::size_t>(child.side)] != 0) return true;
    }
    return false;
}

void UpdateClosure::find_stale() {
    for (std::size_t level = state_.levels.size(); level-- > 0;)
        tbb::parallel_for(first_[level], first_[level + 1], [&](std::size_t k) {
            for (const int side : {0, 1})
                stale_[k][static_cast<std::size_t>(side)] =
                    stale_half(static_cast<int>(level), k, side) ? 1 : 0;
        });
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
    for (std::size_t level = 0; level < state_.levels.size(); ++level)
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
    for (std::size_t k = 0; k < diamonds_.size(); ++k) {
        const std::int32_t page = before_[k] == kNone ? -1 : state_.before.zero_page(before_[k]);
        if (page < 0 || wanted[static_cast<std::size_t>(page)] == 0) continue;
        for (std::uint8_t& stale : stale_[k]) {
            found = found || stale == 0;
            stale = 1;
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
    for (std::size_t level = state_.levels.size(); level-- > 0;)
        tbb::parallel_for(first_[level], first_[level + 1], [&](std::size_t k) {
            for (const int side : {0, 1})
                if (stale_[k][static_cast<std::size_t>(side)] != 0)
                    summarise_half(static_cast<int>(level), k, side);
            job_.progress.step();
        });
}

}  // namespace carat
