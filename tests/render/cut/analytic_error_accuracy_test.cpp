// The picture against the planet's closed formula: off by at most the threshold plus, as seen from the eye,
// E, the file's end-to-end error (source raster, resampling, tolerance) measured densely over the whole
// sphere: as `carat verify --against` measures it, against a raster of the formula four times as fine.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

#include "build/scratch.hpp"
#include "carat/codec/surface.hpp"
#include "carat/globe/patch.hpp"
#include "carat/preprocess/measure.hpp"
#include "carat/render/draw_list.hpp"

namespace carat::test {
namespace {

constexpr double kThreshold = 1.5;  // pixels

double length(const Vec3& v) { return std::hypot(v[0], v[1], v[2]); }

Vec3 random_direction(std::mt19937_64& random) {
    std::normal_distribution<double> gauss;
    Vec3 n{gauss(random), gauss(random), gauss(random)};
    const double size = length(n);
    for (double& x : n) x /= size;
    return n;
}

// Pixels that a distance at a point can be seen as: f d sec(theta) / z.
double pixels(const View& view, const Vec3& v, double distance) {
    return view.focal_pixels() * distance * length(v) / (v[2] * v[2]);
}

// A random point of a random triangle of a patch, metres.
Vec3 random_point(const PatchMesh& mesh, const std::vector<std::array<std::uint16_t, 3>>& triangles,
                  double unit, std::mt19937_64& random) {
    std::uniform_real_distribution<double> share(0, 1);
    const auto& t = triangles[std::uniform_int_distribution<std::size_t>(0, triangles.size() - 1)(random)];
    double a = share(random), b = share(random);
    if (a + b > 1) {
        a = 1 - a;
        b = 1 - b;
    }
    Vec3 out{};
    const std::array<double, 3> weights{1 - a - b, a, b};
    for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t axis = 0; axis < 3; ++axis)
            out[axis] +=
                weights[k] * unit * static_cast<double>(mesh.anchor[axis] + mesh.vertices[t[k]].offset[axis]);
    return out;
}

// Of the file against the formula that the raster in `written` samples.
double measured_error(const std::shared_ptr<const Repository>& file, const synth::Written& written,
                      synth::Options synthetic, const std::filesystem::path& folder) {
    const Ellipsoid body = file->header().ellipsoid();
    synthetic.min_wavelength_m =
        2 * 2 * std::numbers::pi * body.a() / synthetic.size;  // as it has by default
    synthetic.size *= 4;
    for (const synth::Written& fine : synth::write(synth::Kind::moon, folder, synthetic))
        if (fine.name == written.name) {
            LayerOptions layer;
            layer.files = {(folder / fine.name).string()};
            const ErrorSummary errors =
                measure_errors(SourceStack({layer}, body, 0, std::size_t{128} << 20), file);
            EXPECT_GT(errors.all.count, 2'000'000u);
            return errors.all.max;
        }
    ADD_FAILURE() << "no " << written.name;
    return 0;
}

TEST(AnalyticError, IsTheThresholdAndTheFilesErrorAtMost) {
    const Scratch scratch;
    synth::Options synthetic;
    synthetic.size = 512;
    synthetic.inset_size = 16;
    // The global raster alone, so that one formula is the truth everywhere.
    const auto written = synth::write(synth::Kind::moon, scratch.folder, synthetic);
    const auto global = std::max_element(written.begin(), written.end(), [](const auto& l, const auto& r) {
        return l.bounds.east - l.bounds.west < r.bounds.east - r.bounds.west;
    });
    ASSERT_EQ(global->bounds.east - global->bounds.west, 360);
    BuildOptions build;
    build.layers.emplace_back();
    build.layers[0].files = {(scratch.folder / global->name).string()};
    build.body = synth::planet(synth::Kind::moon, synthetic).body;
    build.tolerance = 20;
    build.measure = false;
    build.output = scratch.folder / "moon.carat";
    build_repository(build);

    const auto file = Repository::open(build.output);
    const Surface surface(file);
    const Ellipsoid& body = build.body;
    std::mt19937_64 random(7);
    double e = 0;
    for (int k = 0; k < 100'000; ++k) {
        const Vec3 n = random_direction(random);
        e = std::max(e, std::abs(surface.sample(lattice_position(n)).height - global->truth(n)));
    }
    EXPECT_GT(e, 20) << "the source's samples are 20 km apart";
    const double verified = measured_error(file, *global, synthetic, scratch.folder / "fine");
    EXPECT_GT(verified, e) << "two million samples, and 100,000 random places";
    EXPECT_LT(verified, 1.3 * e);
    e = std::max(e, verified);

    std::uniform_real_distribution<double> share(0, 1);
    std::uint64_t count = 0, past_threshold = 0;
    double greatest = 0;
    for (int v = 0; v < 36; ++v) {
        ViewRequest request;
        request.eye = geodetic(random_direction(random));
        request.height = 12'000 + 2e4 * std::exp(share(random) * std::log(200.0));
        request.heading = 360 * share(random);
        request.pitch = -80 + 70 * share(random);
        request.width = 800;
        request.image_height = 500;
        const View view(body, request);
        const DrawList list = converged_cut(*file, view, kThreshold);
        ASSERT_EQ(list.counters.limited, 0u);
        if (list.meshes.empty()) continue;  // nothing but space
        for (int k = 0; k < 400; ++k) {
            const PatchMesh& mesh =
                *list.meshes[std::uniform_int_distribution<std::size_t>(0, list.meshes.size() - 1)(random)];
            static const std::array triangles{half_triangles(0, 64), half_triangles(1, 64)};
            const Vec3 point =
                random_point(mesh, triangles[static_cast<std::size_t>(mesh.half.side)], view.unit(), random);
            const Vec3 seen = view.to_screen_axes(point);
            if (!(seen[2] > 0) || std::abs(seen[0]) > seen[2] * view.tan_x() ||
                std::abs(seen[1]) > seen[2] * view.tan_y())
                continue;
            // Straight down is no shorter than the way to the nearest point.
            const Ellipsoid::NormalHeight at = body.normal_height(point);
            const double error = std::abs(at.height - global->truth(at.normal));
            const double allowed = kThreshold + pixels(view, seen, e);
            EXPECT_LE(pixels(view, seen, error), allowed);
            greatest = std::max(greatest, pixels(view, seen, error) / allowed);
            past_threshold += pixels(view, seen, error) > kThreshold ? 1 : 0;
            ++count;
        }
        if (HasFailure()) return;
    }
    std::printf("E %.1f m; %llu points, greatest %.3f of what is allowed, %llu past the threshold alone\n", e,
                static_cast<unsigned long long>(count), greatest,
                static_cast<unsigned long long>(past_threshold));
    EXPECT_GT(count, 3000u);
    EXPECT_GT(greatest, 0.2);
}

}  // namespace
}  // namespace carat::test
