#include "render/cut/views.hpp"

#include <cmath>
#include <random>

namespace carat::test {
namespace {

constexpr double kCornerLatitude = 35.264389682754654;  // atan(1/sqrt 2)

const std::vector<std::pair<std::string, Geodetic>>& places() {
    static const std::vector<std::pair<std::string, Geodetic>> list{
        {"land", {37.3, -118.9}},
        {"north pole", {90, 25}},
        {"south pole", {-90, 0}},
        {"cube corner", {kCornerLatitude, 45}},
        {"cube corner south", {-kCornerLatitude, -135}},
        {"cube edge", {12, 45}},
        {"antimeridian", {-16, 180}},
        {"face centre", {0, 90}},
    };
    return list;
}

ViewRequest request(const FakeRepository& repository, const Geodetic& place, double above, double heading,
                    double pitch, double fov) {
    ViewRequest r;
    r.eye = place;
    r.height = above + (above < 1e5 ? repository.surface(place) : 0);
    r.heading = heading;
    r.pitch = pitch;
    r.fov = fov;
    r.width = 320;
    r.image_height = 200;
    return r;
}

}  // namespace

std::vector<NamedView> test_views(const FakeRepository& repository, int random, unsigned seed) {
    const Ellipsoid& body = repository.body();
    const double a = body.a();
    std::vector<NamedView> views;
    const auto add = [&](const std::string& name, const ViewRequest& r) {
        views.push_back({name, View(body, r), r});
    };
    for (const auto& [name, place] : places()) {
        add("orbit over " + name, request(repository, place, 3 * a, 10, -90, 40));
        add("oblique over " + name, request(repository, place, 0.05 * a, 200, -35, 50));
        add("grazing over " + name, request(repository, place, 0.002 * a, 70, -2, 60));
        add("half a metre above " + name, request(repository, place, 0.5, 300, -10, 60));
    }
    std::mt19937_64 generator(seed);
    std::uniform_real_distribution<double> unit(0, 1);
    for (int k = 0; k < random; ++k) {
        const double z = 2 * unit(generator) - 1;
        const Geodetic place{std::asin(z) * 57.29577951308232, 360 * unit(generator) - 180};
        const double above = 0.5 * std::pow(1e8 / 0.5, unit(generator));
        add("random " + std::to_string(k) + ", seed " + std::to_string(seed),
            request(repository, place, above, 360 * unit(generator), -90 + 110 * unit(generator),
                    5 + 85 * unit(generator)));
    }
    return views;
}

}  // namespace carat::test
