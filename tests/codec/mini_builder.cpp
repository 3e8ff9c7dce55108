#include "mini_builder.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/quantize.hpp"

namespace carat::test {
namespace {

Mode mode_of(const MiniPlan& plan, DiamondId d) { return plan.mode ? plan.mode(d) : Mode::interpolating; }

void refine_with_ancestors(MiniBuild& b, DiamondId d) {
    if (!b.refined.insert(d).second || d.level() == 0) return;
    for (int side = 0; side < 2; ++side) refine_with_ancestors(b, *parent(d, side));
}

void choose_diamonds(MiniBuild& b) {
    std::set<DiamondId> level;
    for (int face = 0; face < kFaces; ++face) level.insert(root_diamond(face));
    for (int l = 0; l < b.plan.depth; ++l) {
        std::set<DiamondId> next;
        for (const DiamondId d : level) {
            if (b.plan.refine && !b.plan.refine(d)) continue;
            refine_with_ancestors(b, d);
            for (const DiamondId k : children(d)) next.insert(k);
        }
        level = std::move(next);
    }
    b.levels.resize(1);
    for (int face = 0; face < kFaces; ++face) b.levels[0].insert(root_diamond(face));
    for (const DiamondId d : b.refined) {
        const auto below = static_cast<std::size_t>(d.level()) + 1;
        if (b.levels.size() <= below) b.levels.resize(below + 1);
        for (const DiamondId k : children(d)) b.levels[below].insert(k);
    }
}

Grid sampled(const MiniBuild& b, DiamondId d) {
    const int n = b.plan.n();
    Grid out(static_cast<std::size_t>(n * n));
    for (int side = 0; side < 2; ++side) {
        const HalfFrame frame = half_frame({d, side}, n - 1);
        for_half(n, side, [&](int i, int j) {
            out[static_cast<std::size_t>(i * n + j)] = b.plan.source(frame.vertex(i, j));
        });
    }
    return out;
}

// V and C of a refined diamond out of its children's P: by lattice point, not by gather_half.
RefinedHeights collect(const MiniBuild& b, DiamondId d) {
    const int n = b.plan.n();
    std::map<LatticePoint, std::int32_t> at;
    for (const DiamondId k : children(d)) {
        const Half half{k, half_in_parent(k, d)};
        const HalfFrame frame = half_frame(half, n - 1);
        const Grid& p = b.reference_p.at(k);
        for_half(n, half.side,
                 [&](int i, int j) { at[frame.vertex(i, j)] = p[static_cast<std::size_t>(i * n + j)]; });
    }
    RefinedHeights out{n, Grid(static_cast<std::size_t>(n * n)),
                       Grid(static_cast<std::size_t>((n - 1) * (n - 1)))};
    for (int side = 0; side < 2; ++side) {
        const HalfFrame fine = half_frame({d, side}, 2 * (n - 1));
        for_half(n, side, [&](int i, int j) {
            out.v[static_cast<std::size_t>(i * n + j)] = at.at(fine.vertex(2 * i, 2 * j));
            if (i < n - 1 && j < n - 1)
                out.c[static_cast<std::size_t>(i * (n - 1) + j)] = at.at(fine.vertex(2 * i + 1, 2 * j + 1));
        });
    }
    return out;
}

void analyse(MiniBuild& b) {
    for (auto level = b.levels.rbegin(); level != b.levels.rend(); ++level)
        for (const DiamondId d : *level) {
            if (!b.refined.contains(d)) {
                b.reference_p[d] = sampled(b, d);
                continue;
            }
            RefinedHeights r = collect(b, d);
            Grid& p = b.reference_p[d];
            p = r.v;
            if (mode_of(b.plan, d) != Mode::interpolating) filter_vertices(r, p);
            b.reference[d] = std::move(r);
        }
}

EncodedRoots encode(MiniBuild& b) {
    const int n = b.plan.n();
    std::array<Grid, kFaces> roots;
    for (int face = 0; face < kFaces; ++face)
        roots[static_cast<std::size_t>(face)] = b.reference_p[root_diamond(face)];
    EncodedRoots encoded = encode_roots(roots, n, b.radius);
    for (int face = 0; face < kFaces; ++face)
        b.p[root_diamond(face)] = {n, encoded.heights[static_cast<std::size_t>(face)], {true, true}};
    CodecScratch scratch;
    scratch.statistics = b.plan.statistics;
    for (const auto& level : b.levels)
        for (const DiamondId d : level) {
            if (!b.refined.contains(d)) continue;
            RefinedHeights& out = b.reconstructed[d];
            Coding coding = b.plan.coding;
            if (b.plan.orders) coding.orders = b.plan.orders(d);
            b.residuals[d] = encode_residuals(coding, mode_of(b.plan, d), b.p.at(d).values, b.reference.at(d),
                                              b.radius, out, scratch);
            for (const Half half : {child_halves({d, 0})[0], child_halves({d, 0})[1], child_halves({d, 1})[0],
                                    child_halves({d, 1})[1]}) {
                Heights& child = b.p[half.diamond];
                child.n = n;
                child.values.resize(static_cast<std::size_t>(n * n));
                child.has_half[static_cast<std::size_t>(half.side)] = true;
                gather_half(out, d, half, child.values.data());
            }
        }
    return encoded;
}

// Greatest vertical distance, quanta, between the surface of a half and S beneath it: directly where S is at
// most six levels finer, through the surface six levels finer otherwise.
double vertical_error(const MiniBuild& b, const Half& top, const Half& at, int depth,
                      std::map<Half, double>& known) {
    const int n = b.plan.n();
    const bool leaf = !b.refined.contains(at.diamond);
    if (leaf || depth == 6) {
        const auto dev =
            max_deviation(b.p.at(top.diamond).values.data(), top, b.p.at(at.diamond).values.data(), at, n);
        double beneath = 0;
        if (!leaf) {
            const auto [it, fresh] = known.try_emplace(at, 0.0);
            if (fresh) it->second = vertical_error(b, at, at, 0, known);
            beneath = known.at(at);
        }
        return static_cast<double>(dev) / 8 + beneath;
    }
    double worst = 0;
    for (const Half& child : child_halves(at))
        worst = std::max(worst, vertical_error(b, top, child, depth + 1, known));
    return worst;
}

SummaryValues summarise(MiniBuild& b, const Half& half, std::map<Half, double>& known) {
    const int n = b.plan.n();
    const HeightRange own = height_range(b.p.at(half.diamond).values.data(), n, half.side);
    SummaryValues s{own.min, own.max, 0};
    s.delta = flat_patch_bound(b.plan.body, half, own, b.plan.quantum, n - 1);
    if (b.refined.contains(half.diamond)) {
        s.delta += b.plan.quantum * vertical_error(b, half, half, 0, known);
        for (const Half& child : child_halves(half)) {
            const SummaryValues c = summarise(b, child, known);
            s = {std::min(s.min, c.min), std::max(s.max, c.max), std::max(s.delta, c.delta)};
        }
    }
    return b.summary[half] = s;
}

void write(MiniBuild& b, const EncodedRoots& roots) {
    std::vector<DiamondRecord> records;
    for (const DiamondId d : b.refined)
        records.push_back({d, b.residuals.at(d), {b.summary.at({d, 0}), b.summary.at({d, 1})}});
    WriterSetup setup;
    setup.log2_cells = b.plan.log2_cells;
    setup.quantum = b.plan.quantum;
    setup.tolerance = b.plan.tolerance;
    setup.body = b.plan.body;
    setup.coding = b.plan.coding;
    setup.vertical_datum = b.plan.vertical_datum;
    setup.provenance = b.plan.provenance;
    setup.radii.assign(b.levels.size(), b.radius);
    const std::filesystem::path path =
        std::filesystem::path(::testing::TempDir()) / ("carat_mini_" + std::to_string(::getpid()) + ".carat");
    RepositoryWriter writer(path, setup, roots);
    writer.write(std::move(records));
    writer.finish();
    std::ifstream in(path, std::ios::binary);
    const std::vector<char> chars{std::istreambuf_iterator<char>(in), {}};
    b.bytes.resize(chars.size());
    std::transform(chars.begin(), chars.end(), b.bytes.begin(),
                   [](char c) { return static_cast<std::byte>(c); });
    std::filesystem::remove(path);
}

}  // namespace

std::shared_ptr<const Repository> MiniBuild::open(const std::string& name) const {
    return Repository::open(bytes_in_memory(bytes, name));
}

bool MiniBuild::has_half(const Half& half) const {
    const auto it = p.find(half.diamond);
    return it != p.end() && it->second.has_half[static_cast<std::size_t>(half.side)];
}

std::vector<Half> MiniBuild::leaves() const {
    std::vector<Half> out;
    for (const auto& [d, heights] : p)
        for (int side = 0; side < 2; ++side)
            if (!refined.contains(d) && heights.has_half[static_cast<std::size_t>(side)])
                out.push_back({d, side});
    return out;
}

MiniBuild build_mini(const MiniPlan& plan) {
    MiniBuild b;
    b.plan = plan;
    b.radius = quantizer_radius(plan.tolerance, plan.quantum);
    choose_diamonds(b);
    analyse(b);
    const EncodedRoots roots = encode(b);
    std::map<Half, double> known;
    for (int face = 0; face < kFaces; ++face)
        for (int side = 0; side < 2; ++side) summarise(b, {root_diamond(face), side}, known);
    write(b, roots);
    return b;
}

}  // namespace carat::test
