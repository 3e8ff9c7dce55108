// A queried height against an independent bilinear read of the source at 10,000 random places on land.
//
//   S          the file's surface: reconstructed heights, linear over the leaf triangles
//   S0         the same triangles through unquantised source heights
//   bilinear   GDAL's pixels, textbook bilinear formula
// |S - bilinear| <= |S - S0| + |S0 - bilinear|, and |S - S0| <= epsilon everywhere; so the 99th percentile of
// |S - bilinear| is at most epsilon plus that of |S0 - bilinear|. No place is off by more than the local
// relief.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <random>

#include "bilinear_reader.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/preprocess/build.hpp"
#include "carat/synth/synth.hpp"
#include "support/test_data.hpp"

namespace carat::test {
namespace {

constexpr int kPlaces = 10000;

struct Scratch {
    Scratch()
        : folder(std::filesystem::temp_directory_path() /
                 ("carat-query-" + std::to_string(std::random_device{}()))) {
        std::filesystem::create_directories(folder);
    }
    ~Scratch() { std::filesystem::remove_all(folder); }
    std::filesystem::path folder;
};

// S0: source heights at the corners of the leaf triangle that holds the place.
double unquantised(const Surface& surface, const SourceStack& sources, const RealLattice& place) {
    const int cells = surface.repository().header().cells();
    const Half leaf = leaf_half(surface.repository(), place);
    const Location at = locate_in(place, leaf);
    const TriangleWeights w = triangle_weights(at.s * cells, at.t * cells, cells);
    const HalfFrame frame = half_frame(leaf, cells);
    double height = 0;
    for (std::size_t k = 0; k < 3; ++k)
        if (w.weight[k] != 0)
            height +=
                w.weight[k] * sources.sample(direction(frame.vertex(w.vertex[k][0], w.vertex[k][1]))).height;
    return height;
}

double percentile(std::vector<double>& values, double p) {
    const auto at = static_cast<std::size_t>(p * static_cast<double>(values.size() - 1));
    std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(at), values.end());
    return values[at];
}

void compare_with_bilinear(const std::vector<std::string>& layers, const std::string& reference,
                           double tolerance) {
    const Scratch scratch;
    BuildOptions options;
    for (const std::string& file : layers) options.layers.push_back({{file}});
    options.tolerance = tolerance;
    options.output = scratch.folder / "planet.carat";
    const BuildReport report = build_repository(options);
    EXPECT_LE(report.max_error, tolerance);

    const Surface surface(Repository::open(options.output));
    const SourceStack sources(options.layers, options.body, 0, std::size_t{256} << 20);
    const BilinearReader reader(reference);

    std::mt19937_64 random(20061);
    std::uniform_real_distribution<double> longitude(reader.west() + reader.pixel(),
                                                     reader.east() - reader.pixel());
    std::uniform_real_distribution<double> latitude(reader.south() + reader.pixel(),
                                                    reader.north() - reader.pixel());
    std::vector<double> differences, baselines;
    double worst_quantisation = 0;
    while (differences.size() < kPlaces) {
        const Geodetic g{latitude(random), longitude(random)};
        const double truth = reader.height(g.latitude, g.longitude);
        if (!(truth > 0)) continue;
        const RealLattice place = lattice_position(direction(g));
        const double s = surface.sample(place).height, s0 = unquantised(surface, sources, place);
        differences.push_back(std::abs(s - truth));
        baselines.push_back(std::abs(s0 - truth));
        worst_quantisation = std::max(worst_quantisation, std::abs(s - s0));
        ASSERT_LE(std::abs(s - truth), tolerance + reader.relief(g.latitude, g.longitude, 3))
            << "at " << g.latitude << ", " << g.longitude;
    }
    EXPECT_LE(worst_quantisation, tolerance + 1e-9);
    const double d99 = percentile(differences, 0.99), b99 = percentile(baselines, 0.99);
    std::printf(
        "99th percentile of |S - bilinear| %.3f m; of |S0 - bilinear| %.3f m; epsilon %g m; max |S - S0| "
        "%.3f m\n",
        d99, b99, tolerance, worst_quantisation);
    EXPECT_LE(d99, tolerance + b99);
}

TEST(QueryAccuracy, SyntheticPlanetAgreesWithGdalBilinear) {
    const Scratch scratch;
    synth::Options options;
    options.size = 1440;
    options.inset_size = 2;
    const auto written = synth::write(synth::Kind::earth, scratch.folder, options);
    std::string global;
    for (const auto& w : written)
        if (std::abs(w.bounds.east - w.bounds.west - 360) < 1e-6) global = (scratch.folder / w.name).string();
    ASSERT_FALSE(global.empty());
    compare_with_bilinear({global}, global, 4);
}

TEST(QueryAccuracy, EarthAgreesWithGdalBilinear) {
    CARAT_NEEDS_DATA("earth_5min.tif");
    compare_with_bilinear({data_file("earth_5min.tif")}, data_file("earth_5min.tif"), 10);
}

}  // namespace
}  // namespace carat::test
