// Whole small repositories: what comes back is what the encoder saw, and it keeps every promise of the
// header.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include "carat/codec/quantize.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "globe/random.hpp"
#include "mini_builder.hpp"

namespace carat::test {
namespace {

struct Plan {
    std::string name;
    MiniPlan plan;
};

Mode any_mode(DiamondId d) { return static_cast<Mode>(DiamondIdHash{}(d) % 3); }

// A patch that reaches over a cube edge and down to the given level.
std::function<bool(DiamondId)> patch() {
    return [](DiamondId d) {
        const LatticePoint c = d.centre();
        const std::int64_t s = half_size(d.level());
        return c.x > kLatticeExtent - 3 * s && c.y > kLatticeExtent - 3 * s &&
               std::abs(c.z - kLatticeExtent / 3) < 2 * s;
    };
}

std::vector<Plan> plans() {
    std::vector<Plan> out;
    const std::array<const char*, 4> names{"mode0", "mode1", "mode2", "mixed"};
    for (int mode = 0; mode < 4; ++mode)
        for (const double tolerance : {0.001, 1.0, 100.0}) {
            MiniPlan p;
            p.quantum = default_quantum(tolerance);
            p.tolerance = tolerance;
            p.depth = 4;
            if (mode == 3)
                p.mode = any_mode;
            else
                p.mode = [mode](DiamondId) { return static_cast<Mode>(mode); };
            const auto amplitude = static_cast<std::int32_t>(std::min(9000 / p.quantum, 1e9));
            for (const NamedField& f : all_fields(amplitude, 24)) {
                p.source = f.field;
                out.push_back({f.name + " " + names[static_cast<std::size_t>(mode)] + " " +
                                   std::to_string(tolerance) + " m",
                               p});
            }
        }
    MiniPlan deep;
    deep.source = fractal(2000 * 256, 29, 20);
    deep.depth = 17;
    deep.refine = patch();
    deep.mode = any_mode;
    out.push_back({"patch", deep});
    deep.mode = {};
    deep.depth = 22;
    out.push_back({"deep patch", deep});
    deep.log2_cells = 2;
    out.push_back({"deep patch of tiny cells", deep});
    return out;
}

void expect_equal(const RefinedHeights& a, const RefinedHeights& b) {
    EXPECT_EQ(a.n, b.n);
    EXPECT_TRUE(a.v == b.v);
    EXPECT_TRUE(a.c == b.c);
}

// Calls check(build) for every plan, with the plan's name in the trace.
template <class Check>
void for_every_plan(Check check) {
    for (const Plan& p : plans()) {
        SCOPED_TRACE(p.name);
        check(build_mini(p.plan));
        if (::testing::Test::HasFatalFailure()) return;
    }
}

template <class Visit>
void for_existing_halves(const MiniBuild& b, Visit visit) {
    for (const auto& [d, heights] : b.p)
        for (int side = 0; side < 2; ++side)
            if (heights.has_half[static_cast<std::size_t>(side)]) visit(Half{d, side}, heights);
}

TEST(Repository, DecodesToWhatTheEncoderReconstructed) {
    for_every_plan([](const MiniBuild& b) {
        const auto repository = b.open();
        const RepositoryHeader& h = repository->header();
        EXPECT_EQ(h.refined_diamonds, b.refined.size());
        EXPECT_EQ(h.deepest_level, static_cast<int>(b.levels.size()) - 1);
        EXPECT_EQ(repository->file_bytes(), b.bytes.size());
        const Surface surface(repository);
        for (const auto& [d, heights] : b.p) {
            EXPECT_EQ(repository->refined(d), b.refined.contains(d)) << to_string(d);
            EXPECT_EQ(surface.heights(d)->has_half, heights.has_half);
            if (b.refined.contains(d)) expect_equal(*surface.refined_heights(d), b.reconstructed.at(d));
            for (const DiamondId k : children(d)) EXPECT_EQ(repository->refined(k), b.refined.contains(k));
        }
        for_existing_halves(b, [&](const Half& half, const Heights& heights) {
            const auto read = surface.heights(half.diamond);
            for_half(h.n(), half.side, [&](int i, int j) { ASSERT_EQ(read->at(i, j), heights.at(i, j)); });
        });
    });
}

TEST(Repository, EveryLevelIsWithinTheRadiusOfItsReference) {
    for_every_plan([](const MiniBuild& b) {
        const auto far = [&](std::int32_t a, std::int32_t r) {
            return std::abs(std::int64_t{a} - r) > b.radius ? 1 : 0;
        };
        int wrong = 0;
        for_existing_halves(b, [&](const Half& half, const Heights& heights) {
            const Grid& reference = b.reference_p.at(half.diamond);
            for_half(heights.n, half.side, [&](int i, int j) {
                wrong += far(heights.at(i, j), reference[static_cast<std::size_t>(i * heights.n + j)]);
            });
        });
        for (const auto& [d, r] : b.reconstructed) {
            const RefinedHeights& reference = b.reference.at(d);
            for (std::size_t k = 0; k < r.v.size(); ++k) wrong += far(r.v[k], reference.v[k]);
            for (std::size_t k = 0; k < r.c.size(); ++k) wrong += far(r.c[k], reference.c[k]);
        }
        EXPECT_EQ(wrong, 0);
        EXPECT_LE(b.radius * b.plan.quantum + b.plan.quantum / 2, b.plan.tolerance);
    });
}

// The source in metres, not a multiple of any quantum.
double metres(const LatticePoint& p) {
    const double s = 1.0 / static_cast<double>(kLatticeExtent);
    return 5000 * std::sin(3.1 * s * p.x + 2 * s * p.y) + 800 * std::sin(60 * s * p.z + 31 * s * p.y) +
           0.123456789;
}

TEST(Repository, LeavesAreWithinTheToleranceWithTheRoundingToTheQuantum) {
    for (int mode = 0; mode < 3; ++mode)
        for (const double tolerance : {0.001, 0.3, 1.0, 17.0, 100.0})
            for (const double quantum :
                 {default_quantum(tolerance), tolerance * 2, tolerance / 1.4, 0.01 * tolerance}) {
                MiniPlan plan;
                plan.depth = 4;
                plan.tolerance = tolerance;
                plan.quantum = quantum;
                plan.mode = [mode](DiamondId) { return static_cast<Mode>(mode); };
                plan.source = [quantum](const LatticePoint& p) {
                    return static_cast<std::int32_t>(std::lround(metres(p) / quantum));
                };
                const MiniBuild b = build_mini(plan);
                const Surface surface(b.open());
                double worst = 0;
                for (const Half& leaf : b.leaves()) {
                    const auto heights = surface.heights(leaf.diamond);
                    const HalfFrame f = half_frame(leaf, heights->n - 1);
                    for_half(heights->n, leaf.side, [&](int i, int j) {
                        worst =
                            std::max(worst, std::abs(heights->at(i, j) * quantum - metres(f.vertex(i, j))));
                    });
                }
                EXPECT_LE(worst, tolerance)
                    << "mode " << mode << " tolerance " << tolerance << " quantum " << quantum;
                EXPECT_GT(worst, tolerance / 5) << "a test that cannot fail";
            }
}

TEST(Repository, SharedVerticesAreOneHeightInEveryMixOfModes) {
    for_every_plan([](const MiniBuild& b) {
        const Surface surface(b.open());
        std::map<LatticePoint, std::int32_t> leaf_heights;
        std::map<std::pair<int, LatticePoint>, std::int32_t> level_heights;
        int wrong = 0, shared = 0;
        for_existing_halves(b, [&](const Half& half, const Heights&) {
            const auto heights = surface.heights(half.diamond);
            const HalfFrame f = half_frame(half, heights->n - 1);
            const bool leaf = !b.refined.contains(half.diamond);
            for_half(heights->n, half.side, [&](int i, int j) {
                const LatticePoint p = f.vertex(i, j);
                const std::int32_t h = heights->at(i, j);
                const auto [at, fresh] = level_heights.try_emplace({half.diamond.level(), p}, h);
                wrong += at->second != h ? 1 : 0;
                shared += fresh ? 0 : 1;
                if (leaf) wrong += leaf_heights.try_emplace(p, h).first->second != h ? 1 : 0;
            });
        });
        EXPECT_EQ(wrong, 0);
        EXPECT_GT(shared, 100);
    });
}

// ---- summaries ----

Vec3 difference(const Vec3& a, const Vec3& b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

// A surface of a half: height linear over its triangles (a piece of S), and the flat triangles themselves.
struct Patch {
    const MiniBuild& b;
    Half half;
    HalfFrame frame = half_frame(half, b.plan.n() - 1);
    const Heights& heights = b.p.at(half.diamond);

    TriangleWeights weights(const RealLattice& place) const {
        const Location at = locate_in(place, half);
        const double cells = b.plan.n() - 1;
        const double s = half.side == 0 ? at.s : std::min(at.s, at.t),
                     t = half.side == 0 ? std::min(at.s, at.t) : at.t;
        return triangle_weights(s * cells, t * cells, b.plan.n() - 1);
    }
    Vec3 on_s(const RealLattice& place) const {
        const TriangleWeights w = weights(place);
        double h = 0;
        for (std::size_t k = 0; k < 3; ++k)
            if (w.weight[k] != 0) h += w.weight[k] * heights.at(w.vertex[k][0], w.vertex[k][1]);
        return b.plan.body.position(direction(place), h * b.plan.quantum);
    }
    Vec3 on_flat(const RealLattice& place) const {
        const TriangleWeights w = weights(place);
        Vec3 out{};
        for (std::size_t k = 0; k < 3; ++k) {
            if (w.weight[k] == 0) continue;
            const auto [i, j] = w.vertex[k];
            const Vec3 p =
                b.plan.body.position(direction(frame.vertex(i, j)), heights.at(i, j) * b.plan.quantum);
            for (std::size_t a = 0; a < 3; ++a) out[a] += w.weight[k] * p[a];
        }
        return out;
    }
};

int face_of_half(const Half& half) {
    const HalfFrame f = half_frame(half, 2);
    const LatticePoint inside = half.side == 0 ? f.vertex(2, 1) : f.vertex(1, 2);
    const LatticeVector p =
        wide(inside) + wide(half.side == 0 ? f.vertex(1, 0) : f.vertex(0, 1)) + wide(f.vertex(1, 1));
    for (int face = 0; face < kFaces; ++face)
        if (p[face_axis(face)] * face_sign(face) == 3 * kLatticeExtent) return face;
    return -1;
}

RealLattice place_in(const Half& half, Random& random) {
    const HalfFrame f = half_frame(half, 1);
    double s = random.real(0, 1), t = random.real(0, 1);
    if ((s < t) == (half.side == 0)) std::swap(s, t);
    RealLattice place;
    place.face = face_of_half(half);
    for (int a = 0; a < 3; ++a)
        place.coordinates[static_cast<std::size_t>(a)] = static_cast<double>(f.origin[a]) +
                                                         s * static_cast<double>(f.u[a]) +
                                                         t * static_cast<double>(f.v[a]);
    return place;
}

TEST(Repository, SummariesHoldForAllDescendants) {
    double tightest = 1e300, loosest = 0;
    Random random;
    SCOPED_TRACE(random.trace());
    for_every_plan([&](const MiniBuild& b) {
        const auto repository = b.open();
        const double q = b.plan.quantum;
        std::map<Half, double> distance;  // greatest seen between the flat half and S
        std::int32_t least = INT32_MAX, greatest = INT32_MIN;
        for_existing_halves(b, [&](const Half& half, const Heights& heights) {
            const HeightRange own = height_range(heights.values.data(), heights.n, half.side);
            least = std::min(least, own.min);
            greatest = std::max(greatest, own.max);
            for (std::optional<Half> up = half; up; up = parent_half(*up)) {
                const HalfSummary s = repository->summary(*up);
                ASSERT_LE(s.min_height, q * own.min) << to_string(up->diamond);
                ASSERT_GE(s.max_height, q * own.max) << to_string(up->diamond);
            }
            EXPECT_GE(repository->summary(half).delta, b.summary.at(half).delta);
            if (b.refined.contains(half.diamond)) return;
            const Patch leaf{b, half};
            for (int k = 0; k < 4; ++k) {
                const RealLattice place = place_in(half, random);
                const Vec3 truth = leaf.on_s(place);
                for (std::optional<Half> up = half; up; up = parent_half(*up)) {
                    double& seen = distance[*up];
                    seen = std::max(seen, length(difference(Patch{b, *up}.on_flat(place), truth)));
                }
            }
        });
        EXPECT_EQ(repository->header().min_height, least);
        EXPECT_EQ(repository->header().max_height, greatest);
        for (const auto& [half, seen] : distance) {
            const double delta = repository->summary(half).delta;
            ASSERT_GE(delta, seen - 1e-6) << to_string(half.diamond);  // doubles resolve 1 nm at 1e7 m
            if (b.refined.contains(half.diamond) && seen > 0) {
                tightest = std::min(tightest, delta / seen);
                loosest = std::max(loosest, delta / seen);
            }
        }
    });
    std::cout << "delta over the greatest distance sampled: " << tightest << " to " << loosest << '\n';
}

// ---- sampling S ----

TEST(Repository, SamplesAtVerticesAreTheHeightsThere) {
    MiniPlan plan = plans().back().plan;
    plan.log2_cells = 3;
    const MiniBuild b = build_mini(plan);
    const Surface surface(b.open());
    for (const Half& leaf : b.leaves()) {
        const Heights& heights = b.p.at(leaf.diamond);
        const HalfFrame f = half_frame(leaf, heights.n - 1);
        for_half(heights.n, leaf.side, [&](int i, int j) {
            if ((i * 3 + j) % 5 != 0) return;
            const LatticePoint p = f.vertex(i, j);
            const RealLattice place{
                face_of(p), {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)}};
            const Surface::Sample s = surface.sample(place);
            ASSERT_EQ(s.height, heights.at(i, j) * b.plan.quantum) << to_string(leaf.diamond);
            ASSERT_TRUE(s.at_lattice);
        });
    }
}

TEST(Repository, SamplesBetweenVerticesLieOnTheLeafThatContainsThem) {
    Random random;
    SCOPED_TRACE(random.trace());
    const MiniBuild b = build_mini(plans().back().plan);
    const Surface surface(b.open());
    for (const Half& leaf : b.leaves())
        for (int k = 0; k < 5; ++k) {
            const RealLattice place = place_in(leaf, random);
            const Surface::Sample s = surface.sample(place);
            EXPECT_EQ(s.half, leaf);
            const Vec3 expected = Patch{b, leaf}.on_s(place);
            EXPECT_LT(length(difference(b.plan.body.position(direction(place), s.height), expected)), 1e-6);
            EXPECT_GT(s.spacing, 0);
        }
}

// ---- the file itself ----

TEST(Repository, TheSamePlanGivesTheSameBytes) {
    const auto all = plans();
    for (const std::size_t k : {std::size_t{3}, all.size() / 2, all.size() - 2})
        EXPECT_EQ(build_mini(all[k].plan).bytes, build_mini(all[k].plan).bytes) << all[k].name;
}

TEST(Repository, CountersSayWhatWasRead) {
    MiniPlan plan;
    plan.log2_cells = 3;
    plan.depth = 7;
    plan.source = fractal(1000 * 256);
    const MiniBuild b = build_mini(plan);
    const auto repository = b.open();
    const ReadCounters opened = repository->counters();
    EXPECT_EQ(opened.pages, 0u);
    EXPECT_LT(opened.bytes, b.bytes.size() / 2);
    const Surface surface(repository);
    surface.refined_heights(root_diamond(2));
    EXPECT_EQ(repository->counters().pages, 1u);
    EXPECT_EQ(repository->counters().diamonds_decoded + repository->counters().diamonds_zero, 1u);
    surface.refined_heights(root_diamond(2));
    EXPECT_EQ(repository->counters().diamonds_decoded + repository->counters().diamonds_zero, 1u)
        << "decoded twice";
}

TEST(Repository, ConstantPlanetsAreAFewZeroPages) {
    MiniPlan plan;
    plan.log2_cells = 2;
    plan.source = constant(1234);
    plan.depth = 9;
    const MiniBuild b = build_mini(plan);
    EXPECT_EQ(b.refined.size(), 6u * 511);
    std::cout << b.bytes.size() << " bytes\n";
    EXPECT_LT(b.bytes.size(), 800u);
}

TEST(Repository, LeavesAndForeignersAreUsageErrors) {
    MiniPlan plan;
    plan.depth = 2;
    const auto repository = build_mini(plan).open();
    const Surface surface(repository);
    const DiamondId leaf = child(child(root_diamond(0), 0), 0), absent = child(leaf, 0);
    const auto code = [](auto action) {
        try {
            action();
        } catch (const Error& e) {
            return e.code();
        }
        return ErrorCode::io;
    };
    RefinedHeights out;
    EXPECT_EQ(code([&] { repository->refine(leaf, *surface.heights(leaf), out); }), ErrorCode::usage);
    EXPECT_EQ(code([&] { surface.heights(absent); }), ErrorCode::usage);
    EXPECT_EQ(code([&] { repository->summary({absent, 0}); }), ErrorCode::usage);
}

TEST(Writer, RefusesWhatReadersWouldRefuse) {
    const auto path = std::filesystem::path(::testing::TempDir()) / "carat_refused.carat";
    const auto attempt = [&](auto change, int copies) {
        WriterSetup setup;
        setup.log2_cells = 2;
        setup.quantum = 0.125;
        setup.tolerance = 1;
        setup.radii = {7, 7};
        change(setup);
        std::array<Grid, kFaces> roots;
        roots.fill(Grid(25, 3));
        RepositoryWriter writer(path, setup, encode_roots(roots, 5, 7));
        writer.write(std::vector<DiamondRecord>(static_cast<std::size_t>(copies),
                                                DiamondRecord{root_diamond(0), {}, {}}));
        writer.finish();
    };
    const auto refused = [&](auto change, int copies = 1) {
        std::filesystem::remove(path);
        try {
            attempt(change, copies);
        } catch (const Error& e) {
            EXPECT_FALSE(std::filesystem::exists(path));
            EXPECT_FALSE(std::filesystem::exists(path.string() + ".partial"));
            return e.code() == ErrorCode::usage;
        }
        return false;
    };
    attempt([](WriterSetup&) {}, 1);
    EXPECT_TRUE(std::filesystem::exists(path));
    EXPECT_TRUE(refused([](WriterSetup&) {}, 2));
    EXPECT_TRUE(refused([](WriterSetup& s) { s.radii = {7}; }));
    EXPECT_TRUE(refused([](WriterSetup& s) { s.radii = {7, 8}; }));
    EXPECT_TRUE(refused([](WriterSetup& s) { s.tolerance = 0.01; }));
    EXPECT_TRUE(refused([](WriterSetup& s) { s.quantum = 0; }));
    EXPECT_TRUE(refused([](WriterSetup& s) { s.provenance.assign(std::size_t{1} << 24, 'x'); }));
    std::filesystem::remove(path);
}

}  // namespace
}  // namespace carat::test
