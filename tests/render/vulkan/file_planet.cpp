#include "file_planet.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "carat/codec/surface.hpp"

namespace carat::test {

FilePlanet build_planet(synth::Kind kind, const std::filesystem::path& folder, double tolerance) {
    synth::Options options;
    options.size = 720;
    options.inset_size = 128;
    FilePlanet planet;
    BuildOptions build;
    double finest = std::numeric_limits<double>::infinity();
    for (const synth::Written& w : synth::write(kind, folder, options)) {
        build.layers.push_back({{(folder / w.name).string()}});
        if (!(w.spacing_m < finest) || w.bounds.north > 90) continue;  // degrees
        finest = w.spacing_m;
        planet.detailed = {(w.bounds.south + w.bounds.north) / 2, (w.bounds.west + w.bounds.east) / 2};
    }
    build.body = synth::planet(kind, options).body;
    build.tolerance = tolerance;
    build.log2_cells = kFileLog2Cells;
    build.measure = false;
    build.output = planet.file = folder / "planet.carat";
    build_repository(build);
    return planet;
}

std::vector<FileView> file_views(const FilePlanet& planet, int width, int height) {
    const auto repository = Repository::open(planet.file);
    const Surface surface(repository);
    const Ellipsoid body = repository->header().ellipsoid();
    const double a = body.a();
    std::vector<FileView> views;
    const auto add = [&](const char* manner, const Geodetic& place, double above, double heading,
                         double pitch, double fov, double threshold) {
        const double ground = surface.sample(lattice_position(direction(place))).height;
        ViewRequest request;
        request.eye = place;
        request.height = ground + above;
        request.heading = heading;
        request.pitch = pitch;
        request.fov = fov;
        request.width = width;
        request.image_height = height;
        views.push_back({std::string(manner) + " over " + std::to_string(place.latitude) + ", " +
                             std::to_string(place.longitude),
                         View(body, request), threshold});
    };
    for (const Geodetic& place : {planet.detailed, Geodetic{90, 40}, Geodetic{-17, 180}}) {
        add("orbit", place, 2 * a, 0, -90, 40, 0.004);
        add("limb", place, 0.3 * a, 150, -std::acos(1 / 1.3) * 180 / std::numbers::pi, 6, 0.002);
        add("oblique", place, 0.005 * a, 220, -30, 50, 0.05);
        add("grazing", place, 0.001 * a, 80, -3, 8, 0.25);
        add("ground", place, 3, 130, -4, 30, 0.25);
    }
    return views;
}

DrawRequest picture_request(const View& view) {
    DrawRequest request;
    request.camera = view.camera();
    request.background = {1, 0, 1};
    request.light.direction = {0.6, 0, 0.8};
    request.aovs = {true, true, true, true, true};
    return request;
}

void expect_same_pictures(const Frame& a, const Frame& b, const std::string& what) {
    EXPECT_EQ(a.colour.values, b.colour.values) << what;
    EXPECT_EQ(a.depth.values, b.depth.values) << what;
    EXPECT_EQ(a.position.values, b.position.values) << what;
    EXPECT_EQ(a.normal.values, b.normal.values) << what;
    EXPECT_EQ(a.height.values, b.height.values) << what;
    EXPECT_EQ(a.patch, b.patch) << what;
    EXPECT_EQ(a.triangle, b.triangle) << what;
}

}  // namespace carat::test
