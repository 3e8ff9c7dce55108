// Every hostile input of datasets-synthetic: a right answer or a typed error, and nothing written on failure.
#include <gtest/gtest.h>

#include <cmath>

#include "carat/codec/repository.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

double height_at(const Surface& surface, double latitude, double longitude) {
    return surface.sample(lattice_position(direction(Geodetic{latitude, longitude}))).height;
}

class Hostile : public testing::TestWithParam<synth::Kind> {};

TEST_P(Hostile, LeafSamplesMatchTheSources) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(GetParam(), scratch.folder);
    options.max_level = 16;
    const BuildReport report = build_repository(options);
    EXPECT_LE(report.max_error, options.tolerance);
    const Surface surface(Repository::open(options.output));
    const SourceStack sources(options.layers, options.body, 0, std::size_t{64} << 20);
    for (double latitude = -90; latitude <= 90; latitude += 7.5)
        for (double longitude = -180; longitude <= 180; longitude += 7.5) {
            const RealLattice place = lattice_position(direction(Geodetic{latitude, longitude}));
            const Surface::Sample s = surface.sample(place);
            ASSERT_TRUE(std::isfinite(s.height));
            const auto p = surface.heights(s.half.diamond);
            const int apex = p->n - 1;
            const HalfFrame frame = half_frame(s.half, apex);
            const int i = s.half.side == 0 ? apex : 0, j = s.half.side == 0 ? 0 : apex;
            const double truth = height_at_point(sources, frame.vertex(i, j));
            EXPECT_NEAR(p->at(i, j) * surface.repository().header().quantum, truth, options.tolerance);
        }
}

std::string kind_name(const testing::TestParamInfo<synth::Kind>& info) {
    for (const synth::KindInfo& k : synth::kinds())
        if (k.kind == info.param) return k.name;
    return "unknown";
}

INSTANTIATE_TEST_SUITE_P(Kinds, Hostile,
                         testing::Values(synth::Kind::spikes, synth::Kind::cliff, synth::Kind::checkerboard,
                                         synth::Kind::nonfinite, synth::Kind::int16, synth::Kind::overlap,
                                         synth::Kind::antimeridian, synth::Kind::polar, synth::Kind::rotated),
                         kind_name);

TEST(HostileInputs, ConstantPlanetIsAFewKilobytesAndExact) {
    const Scratch scratch;
    const BuildOptions options = synthetic_build(synth::Kind::constant, scratch.folder);
    const BuildReport report = build_repository(options);
    EXPECT_EQ(report.coded_diamonds, 0u);
    EXPECT_LT(report.file_bytes, 10000u);
    const Surface surface(Repository::open(options.output));
    const double truth = synth::planet(synth::Kind::constant).height({1, 0, 0});
    for (const double latitude : {-90.0, -35.26, 0.0, 45.0, 90.0})
        EXPECT_NEAR(height_at(surface, latitude, 45), truth, options.tolerance);
}

TEST(HostileInputs, AllNodataIsTheBaseHeight) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::nodata, scratch.folder);
    options.base_height = -123;
    const BuildReport report = build_repository(options);
    EXPECT_EQ(report.plan.refined, 0u);
    EXPECT_NEAR(height_at(Surface(Repository::open(options.output)), 12, 34), -123, options.tolerance);
}

TEST(HostileInputs, OnePixelIsBuiltWhereItLies) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::onepixel, scratch.folder);
    options.max_level = 24;
    EXPECT_LE(build_repository(options).max_error, options.tolerance);
    EXPECT_GT(Repository::open(options.output)->header().refined_diamonds, 0u);
}

TEST(HostileInputs, UnreadableFilesAreErrorsThatNameThemAndNothingIsWritten) {
    for (const synth::Kind kind : {synth::Kind::empty, synth::Kind::truncated}) {
        const Scratch scratch;
        const BuildOptions options = synthetic_build(kind, scratch.folder);
        try {
            build_repository(options);
            FAIL() << "built from an unreadable file";
        } catch (const Error& e) {
            const std::string name = std::filesystem::path(options.layers[0].files[0]).filename().string();
            EXPECT_NE(std::string(e.what()).find(name), std::string::npos) << e.what();
        }
        EXPECT_FALSE(std::filesystem::exists(options.output));
        EXPECT_FALSE(std::filesystem::exists(options.output.string() + ".partial"));
    }
}

TEST(HostileInputs, LayersOfTwoBodiesAreRefusedAndNothingIsWritten) {
    const Scratch scratch;
    synth::Options small;
    small.size = 64;
    small.inset_size = 16;
    BuildOptions options = synthetic_build(synth::Kind::earth, scratch.folder, 64);
    const synth::Written moon = synth::write(synth::Kind::moon, scratch.folder / "moon", small).back();
    options.layers.push_back({{(scratch.folder / "moon" / moon.name).string()}});
    try {
        build_repository(options);
        FAIL() << "built of two bodies";
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::usage);
        EXPECT_NE(std::string(e.what()).find(moon.name), std::string::npos) << e.what();
    }
    EXPECT_FALSE(std::filesystem::exists(options.output));
    EXPECT_FALSE(std::filesystem::exists(options.output.string() + ".partial"));
    EXPECT_FALSE(std::filesystem::exists(options.output.string() + ".build"));
}

// Where layers of equal resolution overlap the first one gives the height, in the middle undiluted.
TEST(HostileInputs, OfEqualLayersTheFirstWins) {
    const Scratch scratch;
    BuildOptions options = synthetic_build(synth::Kind::overlap, scratch.folder);
    const std::vector<LayerOptions> given = options.layers;
    ASSERT_EQ(given.size(), 3u);
    options.overwrite = true;
    constexpr double kLatitude = 42.5, kLongitude = 17.5;  // in all three, far from every border
    for (std::size_t first = 0; first < 3; ++first) {
        options.layers = {given[first], given[(first + 1) % 3], given[(first + 2) % 3]};
        build_repository(options);
        const SourceStack alone({given[first]}, options.body, 0, std::size_t{64} << 20);
        const SourceStack::Value truth = alone.sample(direction(Geodetic{kLatitude, kLongitude}));
        ASSERT_EQ(truth.layer, 0);
        // Between lattice points S is linear where the source is bilinear; the layers disagree by 100 m.
        EXPECT_NEAR(height_at(Surface(Repository::open(options.output)), kLatitude, kLongitude), truth.height,
                    options.tolerance + 30);
    }
}

}  // namespace
}  // namespace carat::test
