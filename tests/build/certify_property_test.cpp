// Promises of BuildOptions::certify: the bound holds at every compared source sample, the file says so, and
// where the depth does not suffice it says nothing.
#include <gtest/gtest.h>

#include "carat/globe/error.hpp"
#include "carat/preprocess/measure.hpp"
#include "carat/preprocess/provenance.hpp"
#include "preprocess/raster_maker.hpp"
#include "scratch.hpp"

namespace carat::test {
namespace {

double rough(double u, double v) {
    return 300 * std::sin(u * 0.7) * std::cos(v * 0.9) + 40 * std::sin(u * 2.3);
}

// 64 x 64 samples of a quarter of a degree over a world of one height.
BuildOptions inset_over_world(const Folder& folder) {
    const RasterSpec inset{64, 64, {10, 0.25, 0, 47, 0, -0.25}}, world{90, 45, {-180, 4, 0, 90, 0, -4}};
    BuildOptions options;
    options.layers = {
        layer_of(write_raster(folder.file("inset.tif"), inset, rough)),
        layer_of(write_raster(folder.file("world.tif"), world, [](double, double) { return 5.0; }))};
    options.layers[0].feather.reset();
    options.tolerance = 2;
    options.output = folder.file("out.carat");
    options.overwrite = true;
    return options;
}

Provenance recorded(const BuildOptions& options) {
    return parse_provenance(Repository::open(options.output)->header().provenance);
}

TEST(Certify, TheBoundHoldsAtEverySourceSampleAndTheFileSaysSo) {
    const Folder folder;
    BuildOptions options = inset_over_world(folder);
    const BuildReport plain = build_repository(options);
    ASSERT_GT(plain.errors->all.max, 30) << "without a certificate resampling goes beyond the bound";
    EXPECT_FALSE(recorded(options).certificate);
    options.certify = 30;
    const BuildReport report = build_repository(options);
    ASSERT_TRUE(report.certification && report.certification->reached());
    EXPECT_GT(report.certification->added, 0u);
    EXPECT_EQ(report.plan.refined, plain.plan.refined + report.certification->added);
    EXPECT_EQ(recorded(options).certificate, 30);
    const SourceStack sources(options.layers, options.body, options.base_height, kCache);
    const ErrorSummary errors = measure_errors(sources, Repository::open(options.output));
    EXPECT_LE(errors.all.max, 30);
    EXPECT_EQ(errors.all.count, report.certification->samples);
    EXPECT_GT(errors.all.max, 10) << "no deeper than the bound asks for";
}

TEST(Certify, BytesDoNotDependOnThreads) {
    const Folder folder;
    BuildOptions options = inset_over_world(folder);
    options.certify = 30;
    std::vector<std::string> files;
    for (const int threads : {1, 2, 5}) {
        options.threads = threads;
        build_repository(options);
        files.push_back(bytes_of(options.output));
    }
    EXPECT_TRUE(files[0] == files[1] && files[0] == files[2]);
}

TEST(Certify, WithoutEnoughDepthThereIsNoCertificate) {
    const Folder folder;
    BuildOptions options = inset_over_world(folder);
    options.certify = 30;
    options.max_level = 8;
    const BuildReport report = build_repository(options);
    ASSERT_TRUE(report.certification);
    EXPECT_FALSE(report.certification->reached());
    ASSERT_FALSE(report.certification->worst.empty());
    const WorstPlace& w = report.certification->worst.front();
    EXPECT_GT(std::abs(w.surface - w.source), 28);
    EXPECT_GT(w.latitude, 30);
    EXPECT_LT(w.latitude, 48);
    EXPECT_FALSE(recorded(options).certificate);
    EXPECT_TRUE(recorded(options).errors) << "what was measured is recorded all the same";
}

TEST(Certify, ImpossibleWishesAreRefused) {
    const Folder folder;
    BuildOptions options = inset_over_world(folder);
    options.certify = options.tolerance;
    EXPECT_THROW(build_repository(options), Error);
    options.certify = 30;
    options.mode = Mode::filtered;
    EXPECT_THROW(build_repository(options), Error);
    EXPECT_FALSE(std::filesystem::exists(options.output));
}

}  // namespace
}  // namespace carat::test
