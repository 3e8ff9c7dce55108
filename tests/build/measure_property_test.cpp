// Promises of measure_errors(): the errors are those that a plain loop over the samples finds, each sample is
// compared, blended or hidden by the rule, nothing depends on threads, and a build records what it measured.
#include <gtest/gtest.h>

#include <cmath>

#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "carat/preprocess/measure.hpp"
#include "carat/preprocess/provenance.hpp"
#include "preprocess/raster_maker.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

// Rough enough for errors of every size: octaves of ten metres and more.
double rough(double u, double v) {
    return 300 * std::sin(u * 0.7) * std::cos(v * 0.9) + 40 * std::sin(u * 2.3 + v * 1.9) +
           7 * std::sin(u * 12.9898 + v * 78.233);
}

RasterSpec world() { return {360, 180, {-180, 1, 0, 90, 0, -1}}; }
// 40 x 28 samples of 0.25 degrees, from 10 E to 20 E and 40 N to 47 N.
RasterSpec inset() { return {40, 28, {10, 0.25, 0, 47, 0, -0.25}}; }

struct Build {
    explicit Build(const Folder& folder) {
        options.output = folder.file("out.carat");
        options.tolerance = 2;
        options.max_level = 14;
    }
    void run() { report = build_repository(options); }
    std::shared_ptr<const Repository> file() const { return Repository::open(options.output); }
    SourceStack sources() const {
        return SourceStack(options.layers, options.body, options.base_height, kCache);
    }

    BuildOptions options;
    BuildReport report;
};

struct Plain {
    std::uint64_t count = 0;
    double max = 0, squares = 0, sum = 0;
};

// S - value at the centre of every pixel that `counts`, one after the other.
template <class Counts>
Plain plain_loop(const Surface& surface, const RasterSpec& s, const Value& value, Counts counts) {
    Plain out;
    for (int y = 0; y < s.height; ++y)
        for (int x = 0; x < s.width; ++x) {
            const auto [lon, lat] = to_crs(s, x + 0.5, y + 0.5);
            if (!counts(lon, lat)) continue;
            const double error =
                surface.sample(lattice_position(at(lat, lon))).height - value(x + 0.5, y + 0.5);
            ++out.count;
            out.max = std::max(out.max, std::abs(error));
            out.squares += error * error;
            out.sum += error;
        }
    return out;
}

void expect_equal(const ErrorStats& s, const Plain& p) {
    ASSERT_EQ(s.count, p.count);
    const auto n = static_cast<double>(p.count);
    EXPECT_NEAR(s.max, p.max, 1e-6);
    EXPECT_NEAR(s.rms, std::sqrt(p.squares / n), 1e-6);
    EXPECT_NEAR(s.mean, p.sum / n, 1e-6);
}

constexpr auto kAll = [](double, double) { return true; };

TEST(Measure, AgreesWithAPlainLoop) {
    const Folder folder;
    Build build(folder);
    build.options.layers = {layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.run();
    const ErrorSummary errors = measure_errors(build.sources(), build.file());
    const Plain plain = plain_loop(Surface(build.file()), world(), rough, kAll);
    ASSERT_EQ(errors.layers.size(), 1u);
    expect_equal(errors.layers[0].compared, plain);
    expect_equal(errors.all, plain);
    EXPECT_EQ(errors.layers[0].hidden + errors.layers[0].blended.count, 0u);
    EXPECT_GT(plain.max, build.options.tolerance) << "between lattice points the tolerance is no bound";
}

TEST(Measure, PercentilesAndWorstPlacesAreTrue) {
    const Folder folder;
    Build build(folder);
    build.options.layers = {layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.run();
    const Surface surface(build.file());
    const LayerErrors errors = measure_errors(build.sources(), build.file()).layers.at(0);
    std::vector<double> sizes;
    for (int y = 0; y < 180; ++y)
        for (int x = 0; x < 360; ++x) {
            const auto [lon, lat] = to_crs(world(), x + 0.5, y + 0.5);
            sizes.push_back(
                std::abs(surface.sample(lattice_position(at(lat, lon))).height - rough(x + 0.5, y + 0.5)));
        }
    std::sort(sizes.begin(), sizes.end());
    const auto expect_percentile = [&](double found, double share) {
        const double exact =
            sizes[static_cast<std::size_t>(std::ceil(share * static_cast<double>(sizes.size()))) - 1];
        EXPECT_GE(found, exact - 1e-9);
        EXPECT_LE(found, exact * 1.0161 + 0x1p-16);
    };
    expect_percentile(errors.compared.p50, 0.5);
    expect_percentile(errors.compared.p90, 0.9);
    expect_percentile(errors.compared.p99, 0.99);
    expect_percentile(errors.compared.p999, 0.999);
    const WorstPlace& w = errors.worst.at(0);
    EXPECT_NEAR(std::abs(w.surface - w.source), sizes.back(), 1e-6);
    EXPECT_NEAR(surface.sample(lattice_position(at(w.latitude, w.longitude))).height, w.surface, 1e-3);
}

bool in_inset(double lon, double lat) { return lon > 10 && lon < 20 && lat > 40 && lat < 47; }

TEST(Measure, SamplesBelowAnotherLayerAreHidden) {
    const Folder folder;
    Build build(folder);
    const std::string fine = write_raster(folder.file("inset.tif"), inset(), rough);
    build.options.layers = {layer_of(fine), layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.run();
    const ErrorSummary errors = measure_errors(build.sources(), build.file());
    const Surface surface(build.file());
    expect_equal(errors.layers.at(0).compared, plain_loop(surface, inset(), rough, kAll));
    expect_equal(
        errors.layers.at(1).compared,
        plain_loop(surface, world(), rough, [](double lon, double lat) { return !in_inset(lon, lat); }));
    EXPECT_EQ(errors.layers.at(1).hidden, 10u * 7u) << "rows of samples at 40.5 to 46.5 N";
    EXPECT_EQ(errors.all.count, 360u * 180u - 70u + 40u * 28u);
}

TEST(Measure, FeatheredSamplesAreComparedWithTheBlend) {
    const Folder folder;
    Build build(folder);
    const std::string fine = write_raster(folder.file("inset.tif"), inset(), rough);
    build.options.layers = {layer_of(fine), layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.options.layers[0].feather = 4 * build.sources().layers()[0].spacing;
    build.run();
    const ErrorSummary errors = measure_errors(build.sources(), build.file());
    const LayerErrors& top = errors.layers.at(0);
    // A sample in the k-th row or column from the border is k + 1/2 samples from it: four of them fade.
    EXPECT_EQ(top.compared.count, 32u * 20u);
    EXPECT_EQ(top.blended.count, 40u * 28u - 32u * 20u);
    EXPECT_EQ(top.hidden, 0u);
    EXPECT_EQ(errors.layers.at(1).hidden + errors.layers.at(1).blended.count, 70u);
    EXPECT_LT(top.blended.rms, 60) << "the blend is what the file holds";
}

TEST(Measure, ALayerThatFadesOverNothingIsNotBlended) {
    const Folder folder;
    Build build(folder);
    build.options.layers = {layer_of(write_raster(folder.file("inset.tif"), inset(), rough))};
    build.options.layers[0].feather.reset();
    build.run();
    const LayerErrors errors = measure_errors(build.sources(), build.file()).layers.at(0);
    EXPECT_EQ(errors.compared.count, 40u * 28u);
    EXPECT_EQ(errors.blended.count, 0u);
}

TEST(Measure, HolesProjectionsAndScalesAreRead) {
    const Folder folder;
    Build build(folder);
    RasterSpec utm{50, 40, {500000, 1000, 0, 5000000, 0, -1000}, 32633};
    utm.type = GDT_Int16;
    utm.nodata = -1000;
    utm.scale = 0.5;
    utm.offset = 100;
    const auto stored = [](double u, double v) { return u < 10 && v < 10 ? -1000 : std::round(rough(u, v)); };
    build.options.layers = {layer_of(write_raster(folder.file("utm.tif"), utm, stored))};
    build.options.tolerance = 0.5;
    build.options.max_level = 26;
    build.run();
    const ErrorStats errors = measure_errors(build.sources(), build.file()).layers.at(0).compared;
    EXPECT_EQ(errors.count, 50u * 40u - 100u);
    // Read again by the stack's own kernel, which at the middle of a pixel gives the sample.
    const Surface surface(build.file());
    const SourceStack sources = build.sources();
    const OGRSpatialReference from = srs_of(utm);
    OGRSpatialReference to;
    to.importFromEPSG(4326);
    to.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    const std::unique_ptr<OGRCoordinateTransformation> transform(
        OGRCreateCoordinateTransformation(&from, &to));
    double worst = 0;
    for (int y = 0; y < utm.height; ++y)
        for (int x = 0; x < utm.width; ++x) {
            if (stored(x + 0.5, y + 0.5) == -1000) continue;
            auto [lon, lat] = to_crs(utm, x + 0.5, y + 0.5);
            ASSERT_TRUE(transform->Transform(1, &lon, &lat));
            const double truth = 100 + 0.5 * stored(x + 0.5, y + 0.5);
            EXPECT_NEAR(sources.sample(at(lat, lon)).height, truth, 0.01);
            worst = std::max(worst, std::abs(surface.sample(lattice_position(at(lat, lon))).height - truth));
        }
    EXPECT_NEAR(errors.max, worst, 0.01);
}

TEST(Measure, ThreadsChangeNoBit) {
    const Folder folder;
    Build build(folder);
    build.options.layers = {layer_of(write_raster(folder.file("inset.tif"), inset(), rough)),
                            layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.options.layers[0].feather.reset();
    build.run();
    std::vector<std::string> found;
    for (const int threads : {1, 2, 5}) {
        MeasureOptions options;
        options.threads = threads;
        options.memory_bytes = threads == 2 ? 1 : std::size_t{64} << 20;
        found.push_back(to_json(measure_errors(build.sources(), build.file(), options)));
    }
    EXPECT_EQ(found[0], found[1]);
    EXPECT_EQ(found[0], found[2]);
}

TEST(Measure, ABuildRecordsWhatItMeasured) {
    const Folder folder;
    Build build(folder);
    build.options.layers = {layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.run();
    const Provenance recorded = parse_provenance(build.file()->header().provenance);
    ASSERT_TRUE(build.report.errors && recorded.errors);
    MeasureOptions options;
    options.worst_places = kRecordedPlaces;
    EXPECT_EQ(to_json(*recorded.errors), to_json(measure_errors(build.sources(), build.file(), options)));
    EXPECT_EQ(to_json(*recorded.errors), to_json(error_summary_of_json(to_json(*build.report.errors))));
    build.options.measure = false;
    build.options.overwrite = true;
    build.run();
    EXPECT_FALSE(parse_provenance(build.file()->header().provenance).errors);
}

TEST(Measure, OtherBodiesAreRefused) {
    const Folder folder;
    Build build(folder);
    build.options.layers = {layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.run();
    const SourceStack others(build.options.layers, Ellipsoid::parse("6378137,6378137"), 0, kCache);
    EXPECT_THROW(measure_errors(others, build.file()), Error);
}

TEST(Measure, CanBeCancelled) {
    const Folder folder;
    Build build(folder);
    build.options.layers = {layer_of(write_raster(folder.file("world.tif"), world(), rough))};
    build.run();
    MeasureOptions options;
    options.progress = [](std::uint64_t, std::uint64_t) { return false; };
    EXPECT_THROW(measure_errors(build.sources(), build.file(), options), Error);
}

}  // namespace
}  // namespace carat::test
