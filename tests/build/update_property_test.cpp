// An update gives byte for byte what a full build with the longer list of layers gives, whatever the layer
// and its place; it needs the old sources, and says so.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "../cli/rasters.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/update.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

namespace fs = std::filesystem;

// A planet of 17 x 17 heights a diamond, many diamonds, of three layers.
class UpdateTest : public testing::Test {
  protected:
    void SetUp() override {
        base_ = synthetic_build(synth::Kind::earth, scratch_.folder, 256);
        base_.log2_cells = 4;
        base_.overwrite = true;
        base_.measure = false;
        base_.tolerance = 20;
        while (base_.layers.size() > 3) base_.layers.erase(base_.layers.begin());
        base_.max_level = 17;
    }

    std::string raster(const std::string& name, const Raster& r) const {
        const fs::path file = scratch_.folder / name;
        write_raster(file, r);
        return file.string();
    }
    // Waves and noise; a share of the pixels are holes.
    static Raster rough(const std::array<double, 4>& bounds, int pixels, unsigned seed, double holes = 0) {
        auto random = std::make_shared<std::mt19937>(seed);
        return {pixels, pixels, bounds, [=](double lat, double lon) {
                    std::uniform_real_distribution<double> noise(0, 1);
                    if (noise(*random) < holes) return std::nan("");
                    return 900 + 700 * std::sin(7 * lat + seed) * std::cos(5 * lon) + 60 * noise(*random);
                }};
    }
    // Builds the file, updates it, builds it anew with the layer, compares.
    UpdateReport expect_same(const BuildOptions& base, const LayerOptions& layer, int at,
                             const std::string& what) {
        SCOPED_TRACE(what);
        build_repository(base);
        return expect_same_update(base, layer, at);
    }
    UpdateReport expect_same_update(const BuildOptions& base, const LayerOptions& layer, int at) {
        UpdateOptions update;
        update.file = base.output;
        update.layer = layer;
        update.at = at;
        update.memory_bytes = base.memory_bytes;
        BuildOptions whole = base;
        const UpdateReport report = update_repository(update);
        whole.layers.insert(whole.layers.begin() + (at - 1), layer);
        whole.output = scratch_.folder / "whole.carat";
        const BuildReport built = build_repository(whole);
        EXPECT_EQ(report.plan.refined, built.plan.refined);
        EXPECT_TRUE(bytes_of(base.output) == bytes_of(whole.output)) << "the same bytes";
        EXPECT_EQ(report.file_bytes, built.file_bytes);
        EXPECT_FALSE(fs::exists(base.output.string() + ".partial"));
        return report;
    }

    Scratch scratch_;
    BuildOptions base_;
};

TEST_F(UpdateTest, RandomInsetsAnywhere) {
    std::mt19937 random(4);
    const auto real = [&](double a, double b) { return std::uniform_real_distribution(a, b)(random); };
    for (unsigned round = 0; round < 8; ++round) {
        const double width = std::exp(real(std::log(0.3), std::log(12.0)));
        const double west = real(-180, 180), south = real(-85, 85 - width);
        const int pixels = static_cast<int>(real(20, 120));
        const std::string name = "inset" + std::to_string(round) + ".tif";
        LayerOptions layer{{raster(name, rough({west, south, west + width, south + width}, pixels, round,
                                               round % 3 == 0 ? 0.1 : 0))}};
        if (round % 4 == 1) layer.feather = 0;
        const UpdateReport r = expect_same(base_, layer, 1, name);
        EXPECT_FALSE(r.full);
        EXPECT_GT(r.recoded, 0u);
        EXPECT_LE(r.changed, r.recoded);
        EXPECT_EQ(r.copied + r.changed, r.plan.refined);
    }
}

TEST_F(UpdateTest, PolesAndTheAntimeridian) {
    const std::array<std::array<double, 4>, 3> places{
        {{177, -5, 185, 3}, {-180, 82, 180, 90}, {-180, -90, 180, -84}}};
    for (std::size_t k = 0; k < places.size(); ++k) {
        const std::string name = "edge" + std::to_string(k) + ".tif";
        expect_same(base_, {{raster(name, rough(places[k], 64, 7))}}, 1, name);
    }
}

TEST_F(UpdateTest, EveryPlaceInTheOrder) {
    const LayerOptions layer{{raster("over.tif", rough({5, 40, 25, 60}, 80, 3, 0.05))}};
    for (int at = 1; at <= static_cast<int>(base_.layers.size()) + 1; ++at)
        expect_same(base_, layer, at, "--at " + std::to_string(at));
}

// A coarser layer above a finer one takes depth away.
TEST_F(UpdateTest, ACoarserLayerOnTopRemovesDiamonds) {
    BuildOptions base = base_;
    base.layers.insert(base.layers.begin(),
                       LayerOptions{{raster("fine.tif", rough({10, 10, 12, 12}, 150, 1))}});
    const UpdateReport r =
        expect_same(base, {{raster("coarse.tif", rough({5, 5, 20, 20}, 30, 2))}}, 1, "coarse over fine");
    EXPECT_GT(r.removed, 0u);
}

TEST_F(UpdateTest, UpdatesOfUpdates) {
    build_repository(base_);
    BuildOptions now = base_;
    for (unsigned k = 0; k < 3; ++k) {
        const double west = 20 + 3 * k;
        const LayerOptions layer{
            {raster("step" + std::to_string(k) + ".tif", rough({west, 30, west + 4, 34}, 60, k))}};
        expect_same_update(now, layer, 1);
        now.layers.insert(now.layers.begin(), layer);
    }
}

TEST_F(UpdateTest, AnInsetInAFlatPlanetUnfoldsZeroPages) {
    BuildOptions base = base_;
    base.layers = {{{raster("flat.tif", flat(40))}}};
    base.depth_bias = 1;
    ASSERT_EQ(build_repository(base).coded_diamonds, 0u);
    for (const double width : {0.5, 30.0}) {
        const std::string name = "hill" + std::to_string(static_cast<int>(width)) + ".tif";
        expect_same(base, {{raster(name, rough({10, 10, 10 + width, 10 + width}, 50, 5))}}, 1, name);
    }
    // Flat on flat at the same height: other depths alone.
    expect_same(base,
                {{raster("same.tif", {300, 300, {-30, -30, -20, -20}, [](double, double) { return 40.0; }})}},
                1, "flat");
}

TEST_F(UpdateTest, CodersBiasesAndBaseHeights) {
    const LayerOptions layer{{raster("l.tif", rough({-10, -10, 0, 0}, 100, 9))}};
    BuildOptions gamma = base_;
    gamma.coding = Coding::gamma();
    expect_same(gamma, layer, 1, "gamma");
    BuildOptions fitted = base_;
    RangeStatistics counts;
    for (std::size_t context = 0; context < 128; ++context)
        for (std::size_t token = 0; token < 20; ++token) counts.add(context, token, 1000 / (token + 1));
    fitted.coding.tables = RangeTables::fit(counts);
    fitted.coding.orders = 0b110;
    expect_same(fitted, layer, 1, "the file's own tables, orders 4 and 6");
    EXPECT_TRUE(Repository::open(fitted.output)->header().fitted_tables);
    BuildOptions biased = base_;
    biased.depth_bias = 1.3;
    biased.base_height = -300;
    biased.layers.erase(biased.layers.begin() + 1, biased.layers.end());
    expect_same(biased, layer, 2, "bias, base");
    BuildOptions certified = base_;
    certified.layers = {{{raster("c.tif", rough({0, 0, 6, 6}, 40, 11))}}};
    certified.certify = 60;
    const UpdateReport r =
        expect_same(certified, {{raster("d.tif", rough({2, 2, 3, 3}, 30, 12))}}, 1, "certified");
    EXPECT_TRUE(r.certification.has_value());
}

TEST_F(UpdateTest, FilteringModesAreBuiltAnew) {
    BuildOptions base = base_;
    base.mode = Mode::filtered;
    EXPECT_TRUE(expect_same(base, {{raster("m.tif", rough({0, 0, 5, 5}, 50, 2))}}, 1, "mode 1").full);
}

TEST_F(UpdateTest, WorkIsProportionalToTheClosure) {
    BuildOptions base = base_;
    base.depth_bias = 4;  // more diamonds
    const LayerOptions layer{{raster("town.tif", rough({11, 47, 11.5, 47.5}, 40, 2))}};
    const UpdateReport r = expect_same(base, layer, 1, "a town");
    EXPECT_LT(r.recoded, r.plan.refined / 10) << r.plan.refined;
    EXPECT_LT(r.summaries, 2 * r.plan.refined / 10);
}

// Beneath the new layer a wide feather shows an old one with holes, whose own fades into the next.
TEST_F(UpdateTest, FeathersAndHolesOfOldLayers) {
    BuildOptions base = base_;
    LayerOptions holes{{raster("holes.tif", rough({0, 30, 20, 50}, 700, 21, 0.02))}};
    holes.feather = 30000;
    base.layers.insert(base.layers.begin(), holes);
    LayerOptions wide{{raster("wide.tif", rough({15, 45, 24, 54}, 200, 22, 0.01))}};
    wide.feather = 150000;
    for (const int at : {1, 2}) expect_same(base, wide, at, "wide feather, --at " + std::to_string(at));
}

TEST_F(UpdateTest, Geoids) {
    const std::string geoid =
        raster("geoid.tif",
               {36, 18, {-180, -90, 180, 90}, [](double lat, double lon) { return 0.3 * lat + 0.1 * lon; }});
    BuildOptions base = base_;
    base.vertical_datum = "ellipsoid";
    base.layers = {{{raster("some.tif", rough({0, 0, 40, 40}, 200, 31, 0.01))}}};
    LayerOptions layer{{raster("more.tif", rough({30, 30, 50, 50}, 100, 32))}};
    layer.geoid = geoid;
    expect_same(base, layer, 1, "above");
    // The lowest layer's geoid is that of the base height, all around.
    EXPECT_EQ(expect_same(base, layer, 2, "below").recoded,
              Repository::open(base.output)->header().refined_diamonds);
}

TEST_F(UpdateTest, OldSourcesAreReadWhereTheClosureIs) {
    BuildOptions base = base_;
    base.layers.insert(base.layers.begin(),
                       LayerOptions{{raster("far.tif", rough({-60, -20, -50, -10}, 1500, 8, 0.05))}});
    const UpdateReport r =
        expect_same(base, {{raster("village.tif", rough({11, 47, 11.5, 47.5}, 40, 2))}}, 1, "a village");
    EXPECT_GT(r.tile_reads, 0u);
    EXPECT_LT(r.tile_reads, r.source_tiles * 2 / 3) << "looking for all holes would read all tiles";
}

TEST_F(UpdateTest, TrustedSourcesAreComparedBySize) {
    build_repository(base_);
    UpdateOptions update;
    update.file = base_.output;
    update.layer = {{raster("new.tif", rough({0, 0, 5, 5}, 20, 2))}};
    update.output = scratch_.folder / "checked.carat";
    update_repository(update);
    update.output = scratch_.folder / "trusted.carat";
    update.trust_sources = true;
    update.overwrite = true;
    update_repository(update);
    EXPECT_TRUE(bytes_of(scratch_.folder / "checked.carat") == bytes_of(update.output)) << "hashes included";
    std::fstream(base_.layers[0].files[0], std::ios::in | std::ios::out | std::ios::binary)
            .seekp(-1, std::ios::end)
        << 'x';
    EXPECT_NO_THROW(update_repository(update)) << "a change that keeps the size goes unnoticed";
    update.trust_sources = false;
    EXPECT_THROW(update_repository(update), Error);
    std::ofstream(base_.layers[0].files[0], std::ios::app | std::ios::binary) << "x";
    update.trust_sources = true;
    EXPECT_THROW(update_repository(update), Error);
}

TEST_F(UpdateTest, BytesDoNotDependOnThreads) {
    const LayerOptions layer{{raster("t.tif", rough({100, 10, 110, 20}, 90, 3))}};
    std::string expected;
    for (const int threads : {1, 2, 5}) {
        build_repository(base_);
        UpdateOptions update;
        update.file = base_.output;
        update.layer = layer;
        update.threads = threads;
        update_repository(update);
        if (expected.empty()) expected = bytes_of(base_.output);
        EXPECT_TRUE(bytes_of(base_.output) == expected) << threads;
    }
}

std::string refusal(const UpdateOptions& update) {
    const std::string before = bytes_of(update.file);
    try {
        update_repository(update);
    } catch (const Error& e) {
        EXPECT_EQ(e.code(), ErrorCode::usage) << e.what();
        EXPECT_TRUE(bytes_of(update.file) == before) << "the file is as it was";
        return e.what();
    }
    ADD_FAILURE() << "updated";
    return "";
}

TEST_F(UpdateTest, MissingAndChangedSourcesAreNamed) {
    build_repository(base_);
    UpdateOptions update;
    update.file = base_.output;
    update.layer = {{raster("new.tif", rough({0, 0, 5, 5}, 20, 2))}};
    const fs::path source = base_.layers[0].files[0], away = scratch_.folder / "away";
    fs::create_directory(away);
    fs::rename(source, away / source.filename());
    const std::string missing = refusal(update);
    EXPECT_NE(missing.find(source.filename().string() + " is missing"), std::string::npos) << missing;
    EXPECT_NE(missing.find("--sources"), std::string::npos) << missing;
    update.sources = {away};
    update.output = scratch_.folder / "other.carat";
    EXPECT_NO_THROW(update_repository(update)) << "found where it was said to be";
    EXPECT_NE(refusal(update).find("exists already"), std::string::npos);
    update.output.clear();
    std::ofstream(away / source.filename(), std::ios::app | std::ios::binary) << "x";
    const std::string changed = refusal(update);
    EXPECT_NE(changed.find(source.filename().string() + ": has changed"), std::string::npos) << changed;
}

TEST_F(UpdateTest, FilesThatPromiseAnRmsErrorAreRefused) {
    base_.rms = 5;
    build_repository(base_);
    UpdateOptions update;
    update.file = base_.output;
    update.layer = {{raster("new.tif", rough({0, 0, 5, 5}, 20, 2))}};
    EXPECT_NE(refusal(update).find("promises an RMS error"), std::string::npos);
}

TEST_F(UpdateTest, ImpossiblePlacesAreRefused) {
    build_repository(base_);
    UpdateOptions update;
    update.file = base_.output;
    update.layer = {{raster("new.tif", rough({0, 0, 5, 5}, 20, 2))}};
    for (const int at : {-1, 0, static_cast<int>(base_.layers.size()) + 2}) {
        update.at = at;
        EXPECT_NE(refusal(update).find("are possible"), std::string::npos) << at;
    }
}

}  // namespace
}  // namespace carat::test
