#include <tbb/enumerable_thread_specific.h>
#include <tbb/parallel_for.h>

#include "build_passes.hpp"

namespace carat {
namespace {

struct Worker {
    CodecScratch scratch;
    RefinedHeights reference;
    std::vector<LatticePoint> points;
    std::vector<double> rounding;
    ErrorSum errors;
};

// Lattice points of a diamond's cell centres: the cell's corner plus half of both steps, within each half.
// Cells on the longest edge have their centre on it; either half's frame gives the same point.
void cell_centres(DiamondId d, int cells, std::vector<LatticePoint>& out) {
    const std::array<HalfFrame, 2> frames{half_frame({d, 0}, cells), half_frame({d, 1}, cells)};
    out.clear();
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
            const HalfFrame& f = frames[i >= j ? 0 : 1];
            const LatticeVector twice = 2 * f.origin + (2 * i + 1) * f.u + (2 * j + 1) * f.v;
            out.push_back(narrow({twice.x / 2, twice.y / 2, twice.z / 2}));
        }
}

void gather_vertices(const BuildTree& tree, const FaceHeights& roots, BuildDiamond& d, int n) {
    if (d.id.level() == 0) {
        d.p = roots[static_cast<std::size_t>(d.id.face())];
        return;
    }
    d.p.resize(static_cast<std::size_t>(n * n));
    for (const int side : {0, 1}) {
        const DiamondId up = *parent(d.id, side);
        gather_half(tree.find(up)->refined, up, {d.id, side}, d.p.data());
    }
}

void code_interpolating(const BuildContext& context, BuildDiamond& d, Worker& w) {
    const int n = context.n();
    cell_centres(d.id, n - 1, w.points);
    w.reference.n = n;
    w.reference.v = d.p;
    w.reference.c = sample_points(context, w.points, &w.rounding);
    d.residuals = encode_residuals(context.options.coding, Mode::interpolating, d.p, w.reference,
                                   context.radius, d.refined, w.scratch);
    for (std::size_t k = 0; k < w.rounding.size(); ++k)
        w.errors.add(w.rounding[k] + context.quantum * (w.reference.c[k] - d.refined.c[k]));
}

void code_filtered(const BuildContext& context, BuildDiamond& d, Worker& w) {
    std::swap(w.reference, d.refined);
    d.residuals = encode_residuals(context.options.coding, context.options.mode, d.p, w.reference,
                                   context.radius, d.refined, w.scratch);
    const auto add = [&](std::int32_t a, std::int32_t b) {
        w.errors.add(context.quantum * (std::abs(static_cast<double>(a) - b) + 0.5));
    };
    for (std::size_t k = 0; k < d.refined.c.size(); ++k) add(w.reference.c[k], d.refined.c[k]);
    for (std::size_t k = 0; k < d.refined.v.size(); ++k) add(w.reference.v[k], d.refined.v[k]);
}

}  // namespace

ErrorSum code_tree(const BuildContext& context, const FaceHeights& roots, BuildTree& tree) {
    tbb::enumerable_thread_specific<Worker> workers;
    for (auto& diamonds : tree.levels)
        tbb::parallel_for(std::size_t{0}, diamonds.size(), [&](std::size_t k) {
            BuildDiamond& d = diamonds[k];
            Worker& w = workers.local();
            gather_vertices(tree, roots, d, context.n());
            if (context.options.mode == Mode::interpolating)
                code_interpolating(context, d, w);
            else
                code_filtered(context, d, w);
            context.progress.step();
        });
    ErrorSum sum;
    for (const Worker& w : workers) sum.add(w.errors);
    return sum;
}

}  // namespace carat
