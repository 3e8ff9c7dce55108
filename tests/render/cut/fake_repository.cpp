#include "render/cut/fake_repository.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "carat/globe/bounds.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"

namespace carat::test {
namespace {

double distance(const Vec3& p, const Vec3& q) { return std::hypot(p[0] - q[0], p[1] - q[1], p[2] - q[2]); }

// Index coordinates of a lattice point in a half of `cells` cells, exact in double.
std::array<double, 2> index_of(const Half& half, const LatticePoint& p, int cells) {
    const HalfFrame f = half_frame(half, cells);
    const LatticeVector d = wide(p) - f.origin;
    const auto along = [&](const LatticeVector& axis) {
        double sum = 0, square = 0;
        for (int k = 0; k < 3; ++k) {
            sum += static_cast<double>(d[k]) * static_cast<double>(axis[k]);
            square += static_cast<double>(axis[k]) * static_cast<double>(axis[k]);
        }
        return sum / square;
    };
    return {along(f.u), along(f.v)};
}

template <class Visit>
void visit_vertices(int side, int cells, Visit visit) {
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c) side == 0 ? visit(r, c) : visit(c, r);
}

}  // namespace

double rough_relief(const Vec3& n) {
    double height = 0, frequency = 3, amplitude = 1500;
    for (int octave = 0; octave < 14; ++octave) {
        height += amplitude * std::sin(frequency * (n[0] + 0.7 * n[1]) + octave) *
                  std::sin(frequency * (n[2] - 0.4 * n[0]) + 2 * octave) * std::cos(frequency * n[1]);
        frequency *= 2.1;
        amplitude *= 0.55;
    }
    return height;
}

FakeRepository::FakeRepository(FakeOptions options) : options_(std::move(options)), body_(options_.body) {
    header_.log2_cells = options_.log2_cells;
    header_.quantum = options_.quantum;
    header_.body_a = body_.a();
    header_.body_b = body_.b();
    header_.deepest_level = std::max(options_.depth, options_.deep);
    choose_refined();
    decode_all();
    summarise_all();
}

void FakeRepository::choose_refined() {
    const std::function<void(DiamondId)> close = [&](DiamondId d) {
        if (!refined_.insert(d).second) return;
        for (const int h : {0, 1})
            if (const auto p = parent(d, h)) close(*p);
    };
    const std::function<void(DiamondId, int)> descend = [&](DiamondId d, int level) {
        const bool near = distance(direction(d.centre()), options_.deep_centre) <
                          options_.deep_radius + 3.0 / std::sqrt(std::ldexp(1, level));
        if (level >= options_.depth && !(near && level < options_.deep)) return;
        const bool wanted = level < options_.depth ||
                            distance(direction(d.centre()), options_.deep_centre) < options_.deep_radius;
        if (wanted) close(d);
        for (const DiamondId k : children(d)) descend(k, level + 1);
    };
    for (int face = 0; face < kFaces; ++face) descend(root_diamond(face), 0);
}

std::int32_t FakeRepository::sample(const LatticePoint& p, int level) const {
    const double height = options_.relief(direction(p)) / options_.quantum;
    std::int32_t value = static_cast<std::int32_t>(std::lround(height));
    if (options_.wobble > 0) {
        const std::uint64_t hash = (hash_value(p) ^ static_cast<std::uint64_t>(level)) * 0x9E3779B97F4A7C15u;
        value +=
            static_cast<std::int32_t>((hash >> 33) % static_cast<std::uint64_t>(2 * options_.wobble + 1)) -
            options_.wobble;
    }
    return value;
}

void FakeRepository::refine(DiamondId d, const Heights& p, RefinedHeights& out) const {
    ++refinements_;
    const int n = header_.n(), cells = n - 1, level = d.level();
    const std::array<HalfFrame, 2> frames{half_frame({d, 0}, cells), half_frame({d, 1}, cells)};
    const std::array<HalfFrame, 2> fine{half_frame({d, 0}, 2 * cells), half_frame({d, 1}, 2 * cells)};
    out.n = n;
    out.v = p.values;
    out.c.assign(static_cast<std::size_t>(cells * cells), 0);
    if (options_.wobble > 0)
        for (int i = 1; i < cells; ++i)
            for (int j = 1; j < cells; ++j)
                out.v[static_cast<std::size_t>(i * n + j)] =
                    sample(frames[i >= j ? 0 : 1].vertex(i, j), level);
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j)
            out.c[static_cast<std::size_t>(i * cells + j)] =
                sample(fine[i >= j ? 0 : 1].vertex(2 * i + 1, 2 * j + 1), level);
}

void FakeRepository::decode_all() {
    const int n = header_.n(), cells = n - 1;
    std::vector<DiamondId> order(refined_.begin(), refined_.end());
    std::sort(order.begin(), order.end(), [](DiamondId l, DiamondId r) { return l.level() < r.level(); });
    for (int face = 0; face < kFaces; ++face) {
        Heights& p = heights_[root_diamond(face)];
        p = {n, std::vector<std::int32_t>(static_cast<std::size_t>(n * n)), {true, true}};
        for (const int side : {0, 1}) {
            const HalfFrame f = half_frame({root_diamond(face), side}, cells);
            visit_vertices(side, cells, [&](int i, int j) {
                p.values[static_cast<std::size_t>(i * n + j)] = sample(f.vertex(i, j), -1);
            });
        }
    }
    RefinedHeights refined;
    for (const DiamondId d : order) {
        refine(d, heights_.at(d), refined);
        for (const int side : {0, 1})
            for (const Half& k : child_halves({d, side})) {
                Heights& p = heights_[k.diamond];
                p.n = n;
                p.values.resize(static_cast<std::size_t>(n * n));
                p.has_half[static_cast<std::size_t>(k.side)] = true;
                gather_half(refined, d, k, p.values.data());
            }
    }
}

Vec3 FakeRepository::vertex(const Half& half, int i, int j) const {
    const LatticePoint p = half_frame(half, header_.cells()).vertex(i, j);
    return body_.position(direction(p), heights_.at(half.diamond).at(i, j) * options_.quantum);
}

void FakeRepository::summarise_all() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    header_.min_height = std::numeric_limits<std::int32_t>::max();
    header_.max_height = std::numeric_limits<std::int32_t>::min();
    for (const auto& [d, p] : heights_)
        for (const int side : {0, 1})
            if (p.has_half[static_cast<std::size_t>(side)])
                summaries_[{d, side}] = {kInfinity, -kInfinity, 0};
    for (const auto& [diamond, heights] : heights_)
        for (const int side : {0, 1}) {
            const DiamondId d = diamond;  // clang 14 captures no structured bindings
            const Heights& p = heights;
            if (!p.has_half[static_cast<std::size_t>(side)]) continue;
            std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = -low;
            visit_vertices(side, header_.cells(), [&](int i, int j) {
                low = std::min(low, p.at(i, j));
                high = std::max(high, p.at(i, j));
            });
            header_.min_height = std::min(header_.min_height, low);
            header_.max_height = std::max(header_.max_height, high);
            for (std::optional<Half> h = Half{d, side}; h; h = parent_half(*h)) {
                HalfSummary& s = summaries_.at(*h);
                s.min_height = std::min(s.min_height, low * options_.quantum);
                s.max_height = std::max(s.max_height, high * options_.quantum);
            }
        }
    for (const auto& [d, p] : heights_)
        for (const int side : {0, 1})
            if (!refined(d) && p.has_half[static_cast<std::size_t>(side)]) summarise_leaf({d, side});
    // A leaf stores nothing: it has its parent's range, and the sagitta that this range allows.
    for (const auto& [d, p] : heights_)
        for (const int side : {0, 1}) {
            if (refined(d) || !p.has_half[static_cast<std::size_t>(side)]) continue;
            HalfSummary& s = summaries_.at({d, side});
            if (const auto above = parent_half({d, side})) {
                s.min_height = summaries_.at(*above).min_height;
                s.max_height = summaries_.at(*above).max_height;
            }
            s.delta = curvature_bound(body_, {d, side}, header_.cells())
                          .of_heights(std::max(std::abs(s.min_height), std::abs(s.max_height)),
                                      s.max_height - s.min_height);
        }
}

// Flat patch and S are both linear, up to the leaf's sagitta, on every triangle of the leaf: their greatest
// distance is at its vertices.
void FakeRepository::summarise_leaf(const Half& leaf) {
    const int cells = header_.cells();
    const Heights& p = heights_.at(leaf.diamond);
    std::int32_t low = std::numeric_limits<std::int32_t>::max(), high = -low;
    visit_vertices(leaf.side, cells, [&](int i, int j) {
        low = std::min(low, p.at(i, j));
        high = std::max(high, p.at(i, j));
    });
    const double sagitta = curvature_bound(body_, leaf, cells)
                               .of_heights(std::max(std::abs(low), std::abs(high)) * options_.quantum,
                                           (high - low) * options_.quantum);
    const HalfFrame frame = half_frame(leaf, cells);
    for (std::optional<Half> h = parent_half(leaf); h; h = parent_half(*h)) {
        double worst = 0;
        visit_vertices(leaf.side, cells, [&](int i, int j) {
            const auto [x, y] = index_of(*h, frame.vertex(i, j), cells);
            const TriangleWeights w = triangle_weights(x, y, cells);
            Vec3 flat{};
            for (std::size_t k = 0; k < 3; ++k) {
                const Vec3 corner = w.weight[k] == 0 ? Vec3{} : vertex(*h, w.vertex[k][0], w.vertex[k][1]);
                for (std::size_t axis = 0; axis < 3; ++axis) flat[axis] += w.weight[k] * corner[axis];
            }
            worst = std::max(worst, distance(flat, vertex(leaf, i, j)));
        });
        HalfSummary& s = summaries_.at(*h);
        s.delta = std::max(s.delta, worst + sagitta);
    }
}

Half FakeRepository::leaf_above(Half half) const {
    while (!heights_.contains(half.diamond) || !summaries_.contains(half)) half = *parent_half(half);
    return half;
}

Half FakeRepository::leaf_at(const Half& half, const LatticePoint& p) const {
    Half leaf = leaf_above(half);
    while (refined(leaf.diamond)) {
        const std::array<Half, 2> below = child_halves(leaf);
        const auto [i, j] = index_of(below[0], p, 1);
        const bool inside = below[0].side == 0 ? j >= 0 && i <= 1 && i >= j : i >= 0 && j <= 1 && j >= i;
        leaf = inside ? below[0] : below[1];
    }
    return leaf;
}

double FakeRepository::surface(const Half& leaf, const LatticePoint& p) const {
    const auto [x, y] = index_of(leaf, p, header_.cells());
    const TriangleWeights w = triangle_weights(x, y, header_.cells());
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k)
        if (w.weight[k] != 0)
            height += w.weight[k] * heights_.at(leaf.diamond).at(w.vertex[k][0], w.vertex[k][1]);
    return height;
}

double FakeRepository::surface(const Geodetic& place) const {
    const RealLattice real = lattice_position(direction(place));
    const Half leaf = leaf_above(locate(real, header_.deepest_level).half);
    const Location at = locate_in(real, leaf);
    const int cells = header_.cells();
    const double s = std::clamp(at.s, 0.0, 1.0), t = std::clamp(at.t, 0.0, 1.0);
    const TriangleWeights w = triangle_weights(s * cells, t * cells, cells);
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k)
        height += w.weight[k] * heights_.at(leaf.diamond).at(w.vertex[k][0], w.vertex[k][1]);
    return height * options_.quantum;
}

Vec3 FakeRepository::surface_point(const Half& leaf, const LatticePoint& p) const {
    return body_.position(direction(p), surface(leaf, p) * options_.quantum);
}

}  // namespace carat::test
