// Procedural detail: one height a point, whoever asks; bounds that hold; samples of the file untouched.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <random>

#include "carat/globe/error.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/detail_surface.hpp"
#include "carat/render/refiner.hpp"
#include "detail_code.hpp"
#include "detail_kernel.hpp"
#include "detail_roughness.hpp"
#include "render/cut/support.hpp"

namespace carat::test {
namespace {

std::shared_ptr<const Repository> borrow(const FakeRepository& repository) {
    return {std::shared_ptr<const void>(), &repository};
}

// Down to the spacing of a level, so that the true surface is at hand.
Detail detail_to(const FakeRepository& planet, int level, DetailOptions options = {}) {
    options.to = 1;
    const double spacing = Detail(planet.header(), options).spacing(level);
    options.to = spacing * 1.01;
    return {planet.header(), options};
}

std::vector<DetailOptions> both_modes() {
    DetailOptions uniform;
    uniform.uniform = true;
    uniform.seed = 5;
    return {{}, uniform};
}

TEST(Detail, APointHasOneHeightAndSamplesOfTheFileKeepTheirs) {
    std::uint64_t synthesised = 0, kept = 0, again = 0;
    for (const FakeRepository* planet : {&rough_earth(), &plain_mars()})
        for (const DetailOptions& options : both_modes()) {
            const Detail detail(planet->header(), options);
            const int cells = planet->header().cells();
            std::map<LatticePoint, std::int64_t> heights;
            for (const NamedView& v : test_views(*planet, 6, 3)) {
                const Visibility visibility =
                    visibility_of(planet->header(), planet->body(), v.view, 2, &detail);
                const Cut cut = select_cut(*planet, visibility, 2, 0, nullptr, &detail);
                expect_conforming(cut);
                for (const FrontierHalf& f : cut.frontier) {
                    // Above the leaves, vertices move as they are refined.
                    if (f.culled != Culled::none || !f.is_virtual) continue;
                    std::size_t k = 0;
                    for (int r = 0; r <= cells; ++r)
                        for (int c = 0; c <= r; ++c, ++k) {
                            const LatticePoint p = lattice_vertex(f.half, cells, r, c);
                            const auto [at, fresh] = heights.emplace(p, f.heights.at(k));
                            ASSERT_EQ(at->second, f.heights.at(k)) << v.name;
                            again += fresh ? 0 : 1;
                            if (!fresh) continue;
                            const Half leaf = planet->leaf_at(f.half, p);
                            bool sample = false;
                            for (int i = 0; i <= cells && !sample; ++i)
                                for (int j = 0; j <= i && !sample; ++j)
                                    sample = lattice_vertex(leaf, cells, i, j) == p;
                            const double s = planet->surface(leaf, p);
                            if (sample) {
                                ASSERT_EQ(static_cast<double>(f.heights.at(k)) * kHeightFraction, s);
                            }
                            (sample ? kept : synthesised) += 1;
                        }
                }
            }
        }
    EXPECT_GT(synthesised, 10000u);
    EXPECT_GT(kept, 100u);
    EXPECT_GT(again, 10000u);
}

TEST(Detail, PatchesAreWatertightAndTheirErrorsTrue) {
    std::mt19937_64 generator(3);
    for (const FakeRepository* planet : {&rough_earth(), &plain_mars()})
        for (const DetailOptions& options : both_modes()) {
            const int deep = planet->header().deepest_level + 5;
            const auto detail = std::make_shared<const Detail>(detail_to(*planet, deep, options));
            ASSERT_EQ(detail->end_level(), deep);
            const DetailSurface surface(borrow(*planet), detail);
            RepositoryHeader lowered = planet->header();
            lowered.min_height -= static_cast<std::int32_t>(detail->greatest() / lowered.quantum);
            const TrueSurface truth{
                lowered, planet->body(), [&](const Half&, const LatticePoint& p) {
                    const RealLattice place{face_of(p), {double(p.x), double(p.y), double(p.z)}};
                    return planet->body().position(direction(place), surface.sample(place).height);
                }};
            Seen seen;
            std::array<int, 3> counted{};
            std::uint64_t shared = 0;
            int k = 0;
            for (const NamedView& v : test_views(*planet, 3, 12)) {
                if (k++ % 5 != 0) continue;
                SCOPED_TRACE(v.name);
                const Visibility visibility =
                    visibility_of(planet->header(), planet->body(), v.view, 4, detail.get());
                const Cut cut = select_cut(*planet, visibility, 4, 0, nullptr, detail.get());
                expect_true_errors(truth, v.view, cut, generator, seen);
                expect_culled_unseen(truth, v.view, cut, generator, counted);
                const DrawList list = converged_cut(*planet, v.view, 4, 0, nullptr, detail.get());
                shared += expect_watertight(list, planet->header().cells());
                if (HasFailure()) return;
            }
            EXPECT_GT(seen.tested, 1000u);
            EXPECT_GT(shared, 1000u);
            EXPECT_GT(seen.closest, 0.1);
        }
}

// The same from any camera, in any order, on any number of threads.
TEST(Detail, RefinerDrawsTheConvergedCutWhateverCameBefore) {
    const FakeRepository& planet = rough_earth();
    const auto detail = std::make_shared<const Detail>(planet.header(), DetailOptions{});
    for (const int threads : {1, 3}) {
        RefinerOptions options;
        options.threads = threads;
        options.detail = detail;
        Refiner refiner(borrow(planet), options);
        std::vector<NamedView> views = test_views(planet, 4, 5);
        if (threads == 3) std::reverse(views.begin(), views.end());
        for (const NamedView& v : views) {
            const RefinedFrame frame = refiner.frame(v.view, {2, 3});
            const DrawList wanted = converged_cut(planet, v.view, 2, 3, nullptr, detail.get());
            ASSERT_EQ(frame.draw.size(), wanted.meshes.size()) << v.name;
            for (std::size_t k = 0; k < frame.draw.size(); ++k) {
                ASSERT_EQ(frame.draw[k]->half, wanted.meshes[k]->half);
                for (std::size_t i = 0; i < frame.draw[k]->vertices.size(); ++i) {
                    ASSERT_EQ(frame.draw[k]->vertices[i].offset, wanted.meshes[k]->vertices[i].offset);
                    ASSERT_EQ(frame.draw[k]->vertices[i].normal, wanted.meshes[k]->vertices[i].normal);
                }
            }
        }
    }
}

TEST(Detail, QueriesAreTheHeightsThatAreDrawn) {
    const FakeRepository& planet = rough_earth();
    const auto detail = std::make_shared<const Detail>(detail_to(planet, planet.header().deepest_level + 6));
    const DetailSurface surface(borrow(planet), detail);
    const int cells = planet.header().cells();
    std::uint64_t tested = 0;
    for (const NamedView& v : test_views(planet, 3, 9)) {
        const Visibility visibility = visibility_of(planet.header(), planet.body(), v.view, 1, detail.get());
        for (const FrontierHalf& f : select_cut(planet, visibility, 1, 0, nullptr, detail.get()).frontier) {
            if (f.culled != Culled::none || !f.is_virtual) continue;
            for (int k = 0; k < 20; ++k, ++tested) {
                const int r = k * 5 % (cells + 1), c = r * k / 20;
                const LatticePoint p = lattice_vertex(f.half, cells, r, c);
                const DetailSurface::Sample s =
                    surface.sample({face_of(p), {double(p.x), double(p.y), double(p.z)}});
                ASSERT_NEAR(s.height,
                            static_cast<double>(f.heights.at(half_vertex_index(r, c))) * kHeightFraction *
                                planet.header().quantum,
                            1e-6);
                ASSERT_NE(s.at_lattice, s.synthesised);
            }
        }
    }
    EXPECT_GT(tested, 1000u);
}

TEST(Detail, LevelGroundStaysLevel) {
    const FakeRepository& ball = smooth_ball();
    const Detail detail(ball.header(), {});
    const View view(ball.body(), {{10, 20}, -240, 30, -20, 0, 60, 320, 200});
    const DrawList list = converged_cut(ball, view, 1, 2, nullptr, &detail);
    for (const auto& mesh : list.meshes)
        for (const PatchVertex& v : mesh->vertices) ASSERT_EQ(v.height, -250.0f);
}

TEST(Detail, UniformResidualsStayWithinTheirAmplitudeAndFillIt) {
    const FakeRepository& ball = smooth_ball();
    DetailOptions options;
    options.uniform = true;
    options.amplitude = 0.02;
    const Detail detail(ball.header(), options);
    HalfHeights leaf;
    const int cells = ball.header().cells();
    leaf.whole.assign(half_vertex_count(cells), 1000);
    const Half half{child(child(root_diamond(2), 1), 3), 0};
    detail.begin(ball, half, leaf);
    VirtualHeights refined;
    detail.refine(half.diamond, 2, leaf, leaf, refined);
    double least = 0, most = 0, sum = 0;
    for (int k = 0; k < cells * cells; ++k) {
        const double r = static_cast<double>(refined.c[static_cast<std::size_t>(k)]) * kHeightFraction - 1000;
        least = std::min(least, r);
        most = std::max(most, r);
        sum += r;
    }
    // Level ground: the noise is 0.7 of the amplitude. It may be 6 % less for the linear mantissa, or held by
    // the greatest height of detail.
    const double amplitude = std::min(0.02 * detail.spacing(2), detail.greatest() * (1 - 0.70711) / 1.0615) /
                             ball.header().quantum;
    EXPECT_LE(most, 0.7 * amplitude);
    EXPECT_GE(least, -0.7 * amplitude);
    EXPECT_GT(most, 0.6 * amplitude);
    EXPECT_LT(least, -0.6 * amplitude);
    EXPECT_LT(std::abs(sum) / (cells * cells), 0.1 * amplitude);
}

// Both sides of an edge estimate it alike.
TEST(Detail, RoughnessIsOneAlongEdges) {
    const FakeRepository& planet = plain_mars();
    const int cells = planet.header().cells();
    const auto estimate = [&](const Half& half) {
        const Heights& p = planet.heights(half.diamond);
        std::vector<std::int32_t> heights, out;
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c) heights.push_back(half.side == 0 ? p.at(r, c) : p.at(c, r));
        out.resize(heights.size());
        estimate_roughness(heights, cells, 0, kGreatestAmplitude, out);
        std::map<LatticePoint, std::int32_t> at;
        for (int r = 0; r <= cells; ++r)
            for (int c = 0; c <= r; ++c)
                if (c == 0 || c == r || r == cells)
                    at[lattice_vertex(half, cells, r, c)] = out[half_vertex_index(r, c)];
        return at;
    };
    std::uint64_t shared = 0;
    std::mt19937_64 generator(1);
    for (int k = 0; k < 200; ++k) {
        DiamondId d = root_diamond(static_cast<int>(generator() % 6));
        while (d.level() < planet.header().deepest_level) d = child(d, static_cast<int>(generator() % 4));
        const Half half{d, static_cast<int>(generator() % 2)};
        const auto here = estimate(half);
        const DiamondCorners corner = corners(d);
        for (const int edge : {0, 1, 2}) {
            const Half other = neighbour(half, edge);
            const DiamondCorners theirs = corners(other.diamond);
            for (const auto& [p, r] : estimate(other)) {
                const auto at = here.find(p);
                // Corners belong to several edges: whichever is asked.
                const bool corner_point = p == corner.a || p == corner.b || p == corner.x[0] ||
                                          p == corner.x[1] || p == theirs.a || p == theirs.b ||
                                          p == theirs.x[0] || p == theirs.x[1];
                if (at == here.end() || corner_point) continue;
                ASSERT_EQ(at->second, r);
                ++shared;
            }
        }
    }
    EXPECT_GT(shared, 500u);
}

TEST(Detail, HashIsEvenAndUncorrelatedWithItsNeighbours) {
    constexpr int kSide = 256;
    for (const int scale : {1, 64, 1 << 12}) {
        std::array<int, 16> bins{};
        double product = 0;
        for (int i = 0; i < kSide; ++i)
            for (int j = 0; j < kSide; ++j) {
                const auto u = [&](int x, int y) {
                    return static_cast<std::int32_t>(detail_hash(x * scale, y * scale, 1 << 20, 77)) /
                           2147483648.0;
                };
                ++bins[static_cast<std::size_t>(detail_hash(i * scale, j * scale, 1 << 20, 77) >> 28)];
                product += u(i, j) * (u(i + 1, j) + u(i, j + 1) + u(i + 1, j + 1));
            }
        // 4096 expected a bin, standard deviation 62; the sum of products has sqrt(3 * 65536) / 3 = 148.
        for (const int n : bins) EXPECT_NEAR(n, 4096, 5 * 62);
        EXPECT_NEAR(product, 0, 5 * 148);
    }
    EXPECT_EQ(detail_hash(1, -2, 3, 4), detail_hash(1, -2, 3, 4));
}

TEST(Detail, OptionsAreParsedAndChecked) {
    const DetailOptions o = DetailOptions::parse("seed=7,amplitude=0.5,to=2,slope=20,mode=uniform");
    EXPECT_EQ(o.seed, 7u);
    EXPECT_EQ(o.amplitude, 0.5);
    EXPECT_EQ(o.to, 2);
    EXPECT_EQ(o.slope, 20);
    EXPECT_TRUE(o.uniform);
    EXPECT_FALSE(DetailOptions::parse("").amplitude);
    for (const char* bad : {"seed", "seed=x", "seed=-1", "to=", "amplitude=nan", "mode=odd", "sed=1"})
        EXPECT_THROW(DetailOptions::parse(bad), Error) << bad;
    for (const char* bad : {"to=0", "to=-1", "amplitude=-1", "slope=0", "slope=90"})
        EXPECT_THROW(Detail(rough_earth().header(), DetailOptions::parse(bad)), Error) << bad;
}

}  // namespace
}  // namespace carat::test
