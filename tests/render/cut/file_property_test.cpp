// The same promises on real files: summaries, decoder and cut together.
#include <gtest/gtest.h>

#include <cstring>

#include "build/scratch.hpp"
#include "carat/codec/surface.hpp"
#include "carat/render/refiner.hpp"
#include "render/cut/checks.hpp"
#include "support/test_data.hpp"

namespace carat::test {
namespace {

std::vector<ViewRequest> views(const Surface& surface, const Ellipsoid& body) {
    std::vector<ViewRequest> out;
    const auto add = [&](const Geodetic& place, double above, double heading, double pitch) {
        const double ground = above < 1e5 ? surface.sample(lattice_position(direction(place))).height : 0;
        out.push_back({place, ground + above, heading, pitch, 0, 50, 400, 250});
    };
    const double a = body.a();
    for (const Geodetic& place :
         {Geodetic{35, 100}, Geodetic{90, 40}, Geodetic{-90, 0}, Geodetic{35.2643896827546, 45},
          Geodetic{5, -45}, Geodetic{-17, 180}, Geodetic{18.5, -133}}) {
        add(place, 2 * a, 0, -90);
        add(place, 0.03 * a, 220, -30);
        add(place, 0.001 * a, 80, -3);
        add(place, 0.5, 130, -8);
    }
    return out;
}

void expect_every_promise(const std::filesystem::path& file) {
    const std::shared_ptr<const Repository> repository = Repository::open(file);
    const Surface surface(repository);
    const RepositoryHeader& header = repository->header();
    const Ellipsoid body = header.ellipsoid();
    const TrueSurface truth{header, body, [&](const Half& half, const LatticePoint& p) {
                                // On a cube edge any face that holds the point will do.
                                const RealLattice place{face_of(p), {double(p.x), double(p.y), double(p.z)}};
                                static_cast<void>(half);
                                return body.position(direction(p), surface.sample(place).height);
                            }};
    std::mt19937_64 generator(321);
    Seen seen;
    std::array<int, 3> counted{};
    std::uint64_t shared = 0;
    for (const ViewRequest& request : views(surface, body)) {
        SCOPED_TRACE(std::to_string(request.eye.latitude) + ", " + std::to_string(request.eye.longitude) +
                     ", " + std::to_string(request.height) + " m");
        const View view(body, request);
        const Visibility visibility(view, body, header.min_height * header.quantum,
                                    header.max_height * header.quantum, 2.0);
        const Cut cut = select_cut(*repository, visibility, 2.0);
        EXPECT_EQ(cut.counters.limited, 0u);
        EXPECT_LE(cut.counters.worst_error, 2.0);
        expect_conforming(cut);
        expect_culled_unseen(truth, view, cut, generator, counted);
        expect_true_errors(truth, view, cut, generator, seen);
        shared += expect_watertight(build_draw_list(header, body, cut), header.cells());
        ASSERT_FALSE(testing::Test::HasFailure());
    }
    EXPECT_GT(seen.tested, 2000u);
    EXPECT_GT(shared, 10000u);
    EXPECT_GT(counted[static_cast<std::size_t>(Culled::frustum)], 500);
    EXPECT_GT(counted[static_cast<std::size_t>(Culled::horizon)], 50);
    std::printf("%zu pairs, the closest %.2f of its stated error\n", static_cast<std::size_t>(seen.tested),
                seen.closest);
}

void build_and_expect(synth::Kind kind, Mode mode) {
    const Scratch scratch;
    BuildOptions build = synthetic_build(kind, scratch.folder, 512);
    build.mode = mode;
    build_repository(build);
    expect_every_promise(build.output);
}

TEST(CutOfFile, SyntheticEarth) { build_and_expect(synth::Kind::earth, Mode::interpolating); }
TEST(CutOfFile, SyntheticEarthFiltered) { build_and_expect(synth::Kind::earth, Mode::paper); }
TEST(CutOfFile, Spikes) { build_and_expect(synth::Kind::spikes, Mode::interpolating); }
TEST(CutOfFile, Cliff) { build_and_expect(synth::Kind::cliff, Mode::interpolating); }

// A view from near reads the pages on the way to it, and shows the same when every page has been read before.
TEST(RefinerOfFile, ReadsThePagesThatItNeeds) {
    const Scratch scratch;
    const BuildOptions build = synthetic_build(synth::Kind::earth, scratch.folder, 1024);
    build_repository(build);
    const Ellipsoid body = Repository::open(build.output)->header().ellipsoid();
    const View near(body, {{35, 100}, 20'000, 40, -30, 0, 50, 400, 250});

    const std::shared_ptr<const Repository> fresh = Repository::open(build.output);
    Refiner refiner(fresh);
    const RefinedFrame frame = refiner.frame(near, {2, 0});
    ASSERT_TRUE(frame.converged);

    const std::shared_ptr<const Repository> known = Repository::open(build.output);
    std::vector<DiamondId> open;
    for (int face = 0; face < kFaces; ++face) open.push_back(root_diamond(face));
    while (!open.empty()) {
        const DiamondId d = open.back();
        open.pop_back();
        if (!known->refined(d)) continue;
        for (const DiamondId k : children(d))
            if (parent(k, 0) == d || !parent(k, 0)) open.push_back(k);
    }
    EXPECT_GT(known->counters().pages, 2 * fresh->counters().pages);
    EXPECT_LT(fresh->counters().bytes, known->counters().bytes);
    EXPECT_EQ(frame.counters.read.pages, fresh->counters().pages);
    EXPECT_EQ(frame.counters.decoded + frame.counters.predicted + frame.counters.virtual_refined,
              frame.counters.refined);

    Refiner again(known);
    const RefinedFrame same = again.frame(near, {2, 0});
    ASSERT_EQ(same.draw.size(), frame.draw.size());
    for (std::size_t k = 0; k < same.draw.size(); ++k) {
        ASSERT_EQ(same.draw[k]->half, frame.draw[k]->half);
        ASSERT_EQ(std::memcmp(same.draw[k]->vertices.data(), frame.draw[k]->vertices.data(),
                              same.draw[k]->vertices.size() * sizeof(PatchVertex)),
                  0);
    }
    EXPECT_EQ(same.counters.read.pages, 0u);  // all of them are in the repository's cache
}

// Where all residuals are zero nothing is decoded; the heights are those of the prediction.
TEST(RefinerOfFile, PredictsWhereThereAreNoResiduals) {
    const Scratch scratch;
    BuildOptions build = synthetic_build(synth::Kind::cliff, scratch.folder, 512);
    build.tolerance = 20'000;  // above all relief
    build_repository(build);
    const std::shared_ptr<const Repository> repository = Repository::open(build.output);
    const Ellipsoid body = repository->header().ellipsoid();
    Refiner refiner(repository);
    const RefinedFrame frame =
        refiner.frame(View(body, {{10, 40}, 50'000, 0, -60, 0, 50, 400, 250}), {0.5, 0});
    EXPECT_GT(frame.counters.predicted, 0u);
    EXPECT_EQ(frame.counters.decoded, 0u);
    EXPECT_EQ(frame.counters.predicted + frame.counters.virtual_refined, frame.counters.refined);
}

TEST(CutOfFile, Mars) {
    CARAT_NEEDS_DATA("mars_mola_15min.tif");
    const Scratch scratch;
    BuildOptions build;
    build.layers = {{{data_file("mars_mola_15min.tif")}}};
    build.body = Ellipsoid::mars();
    build.tolerance = 20;
    build.output = scratch.folder / "mars.carat";
    build_repository(build);
    expect_every_promise(build.output);
}

}  // namespace
}  // namespace carat::test
