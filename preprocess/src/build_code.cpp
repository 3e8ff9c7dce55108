#include <cstring>

#include "build_passes.hpp"
#include "packed.hpp"
#include "step_runner.hpp"

namespace carat {
namespace {

constexpr int kLook = 6;  // levels between a patch and the surface it is compared with

// Work space of one thread.
struct Scratch {
    CodecScratch codec;
    RefinedHeights reference;
    std::vector<std::int32_t> child;
    std::vector<std::byte> record;

    static Scratch& of_thread() {
        thread_local Scratch scratch;
        return scratch;
    }
};

// A half above the one at hand, with its heights.
struct Above {
    Half half;
    CodedHeightsPtr heights;
};

class DiamondCoder {
  public:
    DiamondCoder(const BuildContext& context, HeightsCache& cache, const FaceHeights& roots)
        : context_(context), cache_(cache), roots_(roots), s_(Scratch::of_thread()), n_(context.n()) {}

    void code(int level, std::size_t position, std::size_t k, StepOutput& out) {
        level_ = level;
        id_ = context_.ids(level)[position];
        auto coded = std::make_shared<CodedHeights>();
        gather_vertices(*coded);
        read_reference(*coded, position);
        const EncodedResiduals residuals = encode(*coded);
        out[1].second[k] = to_record(residuals);
        DiamondFacts facts;
        find_facts(coded, facts);
        facts.blob_bytes = residuals.blob.size();
        facts.blob_info = residuals.info.to_byte();
        const auto* bytes = reinterpret_cast<const std::byte*>(&facts);
        out[2].second[k].assign(bytes, bytes + sizeof facts);
        if (!has_refined_child_) return;
        out[0].second[k] = cache_.to_record(*coded);
        cache_.put(level, position, std::move(coded));
    }

    static std::vector<std::byte> to_record(const EncodedResiduals& residuals) {
        std::vector<std::byte> record;
        record.reserve(1 + residuals.blob.size());
        record.push_back(static_cast<std::byte>(residuals.info.to_byte()));
        record.insert(record.end(), residuals.blob.begin(), residuals.blob.end());
        return record;
    }

  private:
    bool keeps_p() const { return context_.options.mode != Mode::interpolating; }

    CodedHeightsPtr heights_of(DiamondId d, int level) const {
        return cache_.get(level, *position_of(context_.levels, d, level));
    }

    // P: in mode 0 it becomes V, which the encoder leaves as it is.
    void gather_vertices(CodedHeights& coded) const {
        coded.p.resize(static_cast<std::size_t>(n_ * n_));
        if (level_ == 0) {
            coded.p = roots_[static_cast<std::size_t>(id_.face())];
            return;
        }
        for (const int side : {0, 1}) {
            const DiamondId up = *parent(id_, side);
            gather_half(heights_of(up, level_ - 1)->refined, up, {id_, side}, coded.p.data());
        }
    }

    void read_reference(const CodedHeights& coded, std::size_t position) const {
        context_.store.read({StepKind::reference, level_, position / kStepDiamonds}, position % kStepDiamonds,
                            s_.record);
        RefinedHeights& r = s_.reference;
        r.n = n_;
        r.v.resize(coded.p.size());
        r.c.resize(static_cast<std::size_t>((n_ - 1) * (n_ - 1)));
        std::span<const std::byte> in(s_.record);
        if (keeps_p())
            in = unpack(in, static_cast<std::size_t>(n_), r.v);
        else
            r.v = coded.p;
        unpack(in, static_cast<std::size_t>(n_ - 1), r.c);
    }

    EncodedResiduals encode(CodedHeights& coded) const {
        EncodedResiduals residuals = encode_residuals(context_.options.coding, context_.options.mode, coded.p,
                                                      s_.reference, context_.radius, coded.refined, s_.codec);
        if (!keeps_p()) coded.p = {};
        return residuals;
    }

    void add_errors(const RefinedHeights& coded, ErrorSum& errors) const {
        const auto add = [&](const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
            std::int64_t worst = 0;
            double squares = 0;
            for (std::size_t k = 0; k < a.size(); ++k) {
                const std::int64_t e = std::abs(std::int64_t{a[k]} - b[k]);
                worst = std::max(worst, e);
                squares += static_cast<double>(e) * static_cast<double>(e);
            }
            errors.add(worst, squares, a.size(), context_.quantum);
        };
        add(s_.reference.c, coded.c);
        if (keeps_p()) add(s_.reference.v, coded.v);
    }

    HalfFacts facts_of(const Half& half, const std::int32_t* p) const {
        const HeightRange range = height_range(p, n_, half.side);
        return {range.min, range.max,
                flat_patch_bound(context_.options.body, half, range, context_.quantum, n_ - 1)};
    }

    void find_facts(const CodedHeightsPtr& coded, DiamondFacts& facts) {
        std::memset(static_cast<void*>(&facts), 0, sizeof facts);  // no stray bytes in the file
        facts = {};
        add_errors(coded->refined, facts.errors);
        s_.child.resize(static_cast<std::size_t>(n_ * n_));
        for (const int side : {0, 1}) {
            const Half own{id_, side};
            facts.own[static_cast<std::size_t>(side)] = facts_of(own, coded->vertices().data());
            const std::vector<Above> above = chain(own, coded);
            for (std::size_t leg = 0; leg < 2; ++leg)
                child_facts(child_halves(own)[leg], coded->refined, above,
                            facts.child[static_cast<std::size_t>(2 * side) + leg]);
        }
    }

    // The half itself and those that contain it, up to kLook in all.
    std::vector<Above> chain(const Half& own, const CodedHeightsPtr& coded) const {
        std::vector<Above> out{{own, coded}};
        for (int level = level_ - 1; level >= 0 && out.size() < kLook; --level) {
            const Half up = *parent_half(out.back().half);
            out.push_back({up, heights_of(up.diamond, level)});
        }
        return out;
    }

    void child_facts(const Half& child, const RefinedHeights& refined, const std::vector<Above>& above,
                     ChildFacts& facts) {
        const bool is_refined = position_of(context_.levels, child.diamond, level_ + 1).has_value();
        has_refined_child_ = has_refined_child_ || is_refined;
        if (is_refined && above.size() < kLook) return;
        gather_half(refined, id_, child, s_.child.data());
        if (!is_refined) facts.leaf = facts_of(child, s_.child.data());
        for (std::size_t k = is_refined ? kLook - 1 : 0; k < above.size(); ++k)
            facts.deviation[k] =
                max_deviation(above[k].heights->vertices().data(), above[k].half, s_.child.data(), child, n_);
    }

    const BuildContext& context_;
    HeightsCache& cache_;
    const FaceHeights& roots_;
    Scratch& s_;
    int n_;
    int level_ = 0;
    DiamondId id_;
    bool has_refined_child_ = false;
};

// The files that the reference of a diamond and the heights above it lie in.
void heights_above(const BuildContext& context, DiamondId d, int level, std::set<StepKey>& keys) {
    const auto add = [&](StepKind kind, DiamondId id, int at) {
        keys.insert({kind, at, *position_of(context.levels, id, at) / kStepDiamonds});
    };
    add(StepKind::reference, d, level);
    for (const int side : {0, 1}) {
        Half half{d, side};
        for (int up = 1; up < kLook && up <= level; ++up) {
            half = *parent_half(half);
            add(StepKind::heights, half.diamond, level - up);
        }
    }
}

}  // namespace

void code_levels(const BuildContext& context, const FaceHeights& roots) {
    HeightsCache cache(context.store, context.n(), context.options.mode != Mode::interpolating,
                       context.cache_bytes);
    int level = 0;
    for (; level < context.depth() && context.has_level(StepKind::facts, level); ++level)
        context.progress.step(context.ids(level).size());
    for (; level < context.depth(); ++level) {
        const auto reads = [&](DiamondId d, std::set<StepKey>& keys) {
            heights_above(context, d, level, keys);
        };
        run_level(context, level, {StepKind::heights, StepKind::code, StepKind::facts}, reads,
                  [&](std::size_t position, std::size_t k, StepOutput& out) {
                      DiamondCoder(context, cache, roots).code(level, position, k, out);
                  });
        context.store.drop(StepKind::reference, level);
        if (level >= kLook - 1) context.store.drop(StepKind::heights, level - (kLook - 1));
    }
}

}  // namespace carat
