#include <cmath>

#include "build_passes.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/patch.hpp"
#include "packed.hpp"
#include "step_runner.hpp"

namespace carat {
namespace {

constexpr double kGreatestQuanta = 1 << 30;

// To the nearest integer, ties to even: exact for |x| < 2^51.
double rounded(double x) {
    constexpr double kShift = 6755399441055744.0;  // 1.5 * 2^52
    return (x + kShift) - kShift;
}

void to_quanta(double quantum, std::span<const double> heights, std::span<std::int32_t> out) {
    for (std::size_t k = 0; k < heights.size(); ++k) {
        const double scaled = heights[k] / quantum;
        if (!(std::abs(scaled) <= kGreatestQuanta))
            throw Error(ErrorCode::limit, "a height of " + std::to_string(heights[k]) +
                                              " m exceeds 2^30 quanta; choose a larger --quantum");
        out[k] = static_cast<std::int32_t>(rounded(scaled));
    }
}

template <class F>
void for_half(int n, int side, F f) {
    for (int i = 0; i < n; ++i)
        for (int j = side == 0 ? 0 : i; j < (side == 0 ? i + 1 : n); ++j) f(i, j);
}

// Heights of a child's half, in rows, to where they stand in its parent's V and C.
void scatter(DiamondId d, const Half& child, const std::int32_t* next, int n, RefinedHeights& out) {
    const ChildMap m = child_map(d, child, n - 1);
    for_half(n, child.side, [&](int i, int j) {
        const int p = m.p0 + i * m.pi + j * m.pj, q = m.q0 + i * m.qi + j * m.qj;
        std::int32_t& to = (p & 1) == 0 ? out.v[static_cast<std::size_t>((p >> 1) * n + (q >> 1))]
                                        : out.c[static_cast<std::size_t>((p >> 1) * (n - 1) + (q >> 1))];
        to = *next++;
    });
}

// Work space of one thread.
struct Scratch {
    std::vector<double> heights;
    std::vector<std::int32_t> quarter, child, filtered;
    std::vector<std::byte> record;
    RefinedHeights refined;

    static Scratch& of_thread() {
        thread_local Scratch scratch;
        return scratch;
    }
};

// Reference heights of a diamond from the four child halves that tile it.
class Gatherer {
  public:
    Gatherer(const BuildContext& context, Scratch& scratch)
        : context_(context), s_(scratch), n_(context.n()) {}

    // Into scratch.refined.
    void gather(DiamondId d, int level) {
        s_.refined.n = n_;
        s_.refined.v.resize(static_cast<std::size_t>(n_ * n_));
        s_.refined.c.resize(static_cast<std::size_t>((n_ - 1) * (n_ - 1)));
        for (const int side : {0, 1})
            for (const Half& child : child_halves({d, side})) fill(d, child, level + 1);
    }

  private:
    void fill(DiamondId d, const Half& child, int level) {
        take(child, level);
        scatter(d, child, s_.quarter.data(), n_, s_.refined);
    }
    // The vertices of a child's half: of the refined child, or source samples.
    void take(const Half& child, int level) {
        s_.quarter.resize(half_vertex_count(n_ - 1));
        const std::optional<std::size_t> refined = position_of(context_.levels, child.diamond, level);
        if (!refined) {
            s_.heights.resize(s_.quarter.size());
            context_.sources.sample(child, n_ - 1, s_.heights);
            return to_quanta(context_.quantum, s_.heights, s_.quarter);
        }
        context_.store.read({StepKind::vertices, level, *refined / kStepDiamonds}, *refined % kStepDiamonds,
                            s_.record);
        s_.child.resize(static_cast<std::size_t>(n_ * n_));
        unpack(s_.record, static_cast<std::size_t>(n_), s_.child);
        std::int32_t* next = s_.quarter.data();
        for_half(n_, child.side,
                 [&](int i, int j) { *next++ = s_.child[static_cast<std::size_t>(i * n_ + j)]; });
    }

    const BuildContext& context_;
    Scratch& s_;
    int n_;
};

// The files that the vertices of a diamond's children lie in.
void vertices_below(const BuildContext& context, DiamondId d, int level, std::set<StepKey>& keys) {
    for (const int side : {0, 1})
        for (const Half& child : child_halves({d, side}))
            if (const auto at = position_of(context.levels, child.diamond, level + 1))
                keys.insert({StepKind::vertices, level + 1, *at / kStepDiamonds});
}

void reference_level(const BuildContext& context, int level) {
    const bool filters = context.options.mode != Mode::interpolating;
    const auto n = static_cast<std::size_t>(context.n());
    const auto reads = [&](DiamondId d, std::set<StepKey>& keys) { vertices_below(context, d, level, keys); };
    run_level(context, level, {StepKind::vertices, StepKind::reference}, reads,
              [&](std::size_t position, std::size_t k, StepOutput& out) {
                  Scratch& s = Scratch::of_thread();
                  Gatherer(context, s).gather(context.ids(level)[position], level);
                  if (filters) {
                      s.filtered.resize(s.refined.v.size());
                      filter_vertices(s.refined, s.filtered);
                      pack(s.refined.v, n, out[1].second[k]);
                  }
                  pack(filters ? s.filtered : s.refined.v, n, out[0].second[k]);
                  pack(s.refined.c, n - 1, out[1].second[k]);
              });
}

}  // namespace

std::vector<std::int32_t> sample_face(const SourceStack& sources, double quantum, int n, int face) {
    const HalfFrame frame = half_frame({root_diamond(face), 0}, n - 1);
    std::vector<LatticePoint> points;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) points.push_back(frame.vertex(i, j));
    std::vector<double> heights(points.size());
    sources.sample(points, heights);
    std::vector<std::int32_t> quanta(points.size());
    to_quanta(quantum, heights, quanta);
    return quanta;
}

// In mode 0 the reference of a refined diamond is the source at its vertices and cell centres.
void sample_reference(const SourceStack& sources, double quantum, int n, DiamondId d, RefinedHeights& out) {
    Scratch& s = Scratch::of_thread();
    out.n = n;
    out.v.resize(static_cast<std::size_t>(n * n));
    out.c.resize(static_cast<std::size_t>((n - 1) * (n - 1)));
    s.heights.resize(half_vertex_count(n - 1));
    s.quarter.resize(half_vertex_count(n - 1));
    for (const int side : {0, 1})
        for (const Half& child : child_halves({d, side})) {
            sources.sample(child, n - 1, s.heights);
            to_quanta(quantum, s.heights, s.quarter);
            scatter(d, child, s.quarter.data(), n, out);
        }
}

FaceHeights make_reference(const BuildContext& context) {
    // Levels whose reference is complete, or has been coded and dropped, are not looked at again.
    int level = context.depth();
    while (level > 0 && context.has_level(StepKind::reference, level - 1)) --level;
    if (context.depth() > 0 && context.has_level(StepKind::facts, 0)) level = 0;
    for (int done = context.depth(); done-- > level;) context.progress.step(context.ids(done).size());
    while (level-- > 0) {
        reference_level(context, level);
        if (level + 1 < context.depth()) context.store.drop(StepKind::vertices, level + 1);
    }
    FaceHeights roots;
    for (int face = 0; face < kFaces; ++face) {
        auto& out = roots[static_cast<std::size_t>(face)];
        const auto refined = position_of(context.levels, root_diamond(face), 0);
        if (context.options.mode == Mode::interpolating || !refined) {
            out = sample_face(context.sources, context.quantum, context.n(), face);
            continue;
        }
        std::vector<std::byte> record;
        context.store.read({StepKind::vertices, 0, *refined / kStepDiamonds}, *refined % kStepDiamonds,
                           record);
        out.resize(static_cast<std::size_t>(context.n() * context.n()));
        unpack(record, static_cast<std::size_t>(context.n()), out);
    }
    return roots;
}

}  // namespace carat
