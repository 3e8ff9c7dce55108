#include <tbb/parallel_for.h>

#include "build_passes.hpp"

namespace carat {
namespace {

// The value of a refined grid at doubled indices (both even: vertex, both odd: cell centre).
std::int32_t& refined_at(RefinedHeights& r, int p, int q) {
    return (p & 1) == 0 ? r.v[static_cast<std::size_t>((p >> 1) * r.n + (q >> 1))]
                        : r.c[static_cast<std::size_t>((p >> 1) * (r.n - 1) + (q >> 1))];
}

template <class F>
void for_half(int n, int side, F f) {
    for (int i = 0; i < n; ++i)
        for (int j = side == 0 ? 0 : i; j < (side == 0 ? i + 1 : n); ++j) f(i, j);
}

// Reference values in one quarter of a diamond: the filtered P of a refined child, or source samples.
void fill_quarter(const BuildContext& context, const BuildTree& tree, BuildDiamond& d, const Half& child) {
    const int n = context.n();
    const ChildMap m = child_map(d.id, child, n - 1);
    const BuildDiamond* refined_child = tree.find(child.diamond);
    std::vector<std::int32_t> values;
    if (refined_child == nullptr) {
        const HalfFrame frame = half_frame(child, n - 1);
        std::vector<LatticePoint> points;
        for_half(n, child.side, [&](int i, int j) { points.push_back(frame.vertex(i, j)); });
        values = sample_points(context, points, nullptr);
    } else {
        for_half(n, child.side, [&](int i, int j) {
            values.push_back(refined_child->p[static_cast<std::size_t>(i * n + j)]);
        });
    }
    std::size_t k = 0;
    for_half(n, child.side, [&](int i, int j) {
        refined_at(d.refined, m.p0 + i * m.pi + j * m.pj, m.q0 + i * m.qi + j * m.qj) = values[k++];
    });
}

void filter_diamond(const BuildContext& context, const BuildTree& tree, BuildDiamond& d) {
    const int n = context.n();
    d.refined.n = n;
    d.refined.v.resize(static_cast<std::size_t>(n * n));
    d.refined.c.resize(static_cast<std::size_t>((n - 1) * (n - 1)));
    for (const int side : {0, 1})
        for (const Half& child : child_halves({d.id, side})) fill_quarter(context, tree, d, child);
    d.p.resize(d.refined.v.size());
    filter_vertices(d.refined, d.p);
}

}  // namespace

FaceHeights filter_tree(const BuildContext& context, BuildTree& tree) {
    for (int level = tree.depth(); level-- > 0;) {
        auto& diamonds = tree.levels[static_cast<std::size_t>(level)];
        tbb::parallel_for(std::size_t{0}, diamonds.size(), [&](std::size_t k) {
            filter_diamond(context, tree, diamonds[k]);
            context.progress.step();
        });
    }
    FaceHeights roots = sample_roots(context);
    for (int face = 0; face < kFaces; ++face)
        if (const BuildDiamond* d = tree.find(root_diamond(face)))
            roots[static_cast<std::size_t>(face)] = d->p;
    return roots;
}

}  // namespace carat
