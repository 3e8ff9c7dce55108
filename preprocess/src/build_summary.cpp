#include <cstring>

#include "build_passes.hpp"

namespace carat {
namespace {

constexpr int kLook = 6;

// A half on its way to its summary.
struct HalfState {
    double flat = 0, delta = 0;
};
using LevelState = std::vector<std::array<HalfState, 2>>;

template <class F>
void for_facts(const BuildContext& context, int level, F f) {
    std::size_t position = 0;
    for (std::size_t step = 0; step < context.steps(level); ++step)
        for (const std::vector<std::byte>& record : context.store.read_all({StepKind::facts, level, step})) {
            DiamondFacts facts;
            std::memcpy(static_cast<void*>(&facts), record.data(), sizeof facts);
            f(position++, facts);
        }
}

// delta(h) = max(flat(h), delta of its children,
//                flat(h) + greatest deviation from the half g + delta(g) over the halves g six levels finer,
//                or leaves), rounded outwards to the file's grid, as are heights, before it goes further up.
class Summariser {
  public:
    explicit Summariser(const BuildContext& context)
        : context_(context), grid_(context.options.body.a(), context.quantum, context.options.log2_cells) {}

    Summaries run() {
        std::size_t count = 0;
        for (int level = 0; level < context_.depth(); ++level) {
            first_.push_back(count);
            count += context_.ids(level).size();
        }
        out_.diamonds.resize(count);
        for (int level = 0; level < context_.depth(); ++level) read_own(level);
        for (int level = context_.depth(); level-- > 0;)
            for_facts(context_, level, [&](std::size_t position, const DiamondFacts& facts) {
                for (const int side : {0, 1}) finish(level, position, side, facts);
                context_.progress.step();
            });
        return std::move(out_);
    }

  private:
    void read_own(int level) {
        auto& states = states_.emplace_back(context_.ids(level).size());
        for_facts(context_, level, [&](std::size_t position, const DiamondFacts& facts) {
            DiamondEntry& entry = entry_at(level, position);
            entry.id = context_.ids(level)[position];
            entry.info = BlobInfo::from_byte(static_cast<std::uint8_t>(facts.blob_info));
            entry.blob_bytes = facts.blob_bytes;
            out_.blob_bytes += facts.blob_bytes;
            for (std::size_t side = 0; side < 2; ++side) {
                const HalfFacts& own = facts.own[side];
                entry.summary[side] = {own.min, own.max, 0};
                states[position][side] = {own.flat, 0};
            }
            out_.errors.add(facts.errors);
        });
    }

    // Takes in the two child halves of a half; what lies deeper has been folded in already.
    void finish(int level, std::size_t position, int side, const DiamondFacts& facts) {
        const auto s = static_cast<std::size_t>(side);
        const Half own{context_.ids(level)[position], side};
        SummaryValues& summary = entry_at(level, position).summary[s];
        HalfState& state = states_[static_cast<std::size_t>(level)][position][s];
        const auto legs = child_halves(own);
        for (std::size_t leg = 0; leg < 2; ++leg) {
            const ChildFacts& child = facts.child[2 * s + leg];
            const auto refined = position_of(context_.levels, legs[leg].diamond, level + 1);
            const SummaryValues there =
                refined ? entry_at(level + 1, *refined).summary[static_cast<std::size_t>(legs[leg].side)]
                        : SummaryValues{child.leaf.min, child.leaf.max, child.leaf.flat};
            summary.min = std::min(summary.min, there.min);
            summary.max = std::max(summary.max, there.max);
            state.delta = std::max(state.delta, there.delta);
            fold(own, level, child, refined.has_value(), there.delta);
        }
        summary.delta = state.delta;
        summary = grid_.rounded(summary, level);
    }

    void fold(const Half& own, int level, const ChildFacts& child, bool refined, double delta) {
        Half half = own;
        for (int up = 0; up < kLook && up <= level; ++up) {
            if (up > 0) half = *parent_half(half);
            if (refined && up < kLook - 1) continue;
            const int at = level - up;
            HalfState& state = states_[static_cast<std::size_t>(at)][*position_of(
                context_.levels, half.diamond, at)][static_cast<std::size_t>(half.side)];
            const double dev = static_cast<double>(child.deviation[static_cast<std::size_t>(up)]) / 8;
            state.delta = std::max(state.delta, state.flat + context_.quantum * dev + delta);
        }
    }

    DiamondEntry& entry_at(int level, std::size_t position) {
        return out_.diamonds[first_[static_cast<std::size_t>(level)] + position];
    }

    const BuildContext& context_;
    SummaryGrid grid_;
    std::vector<std::size_t> first_;  // of each level
    std::vector<LevelState> states_;
    Summaries out_;
};

}  // namespace

Summaries summarise_levels(const BuildContext& context) { return Summariser(context).run(); }

}  // namespace carat
