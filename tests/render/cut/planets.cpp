#include "render/cut/planets.hpp"

namespace carat::test {

const FakeRepository& rough_earth() {
    static const FakeRepository repository([] {
        FakeOptions o;
        o.relief = rough_relief;
        o.depth = 5;
        o.deep = 12;
        o.deep_centre = direction(Geodetic{37.3, -118.9});
        o.deep_radius = 0.02;
        o.wobble = 2000;
        return o;
    }());
    return repository;
}

const FakeRepository& plain_mars() {
    static const FakeRepository repository([] {
        FakeOptions o;
        o.body = Ellipsoid::mars();
        o.log2_cells = 2;
        o.relief = [](const Vec3& n) { return 2 * rough_relief(n) - 1000; };
        o.depth = 7;
        return o;
    }());
    return repository;
}

const FakeRepository& smooth_ball() {
    static const FakeRepository repository([] {
        FakeOptions o;
        o.body = Ellipsoid(1e6, 1e6);
        o.log2_cells = 4;
        o.relief = [](const Vec3&) { return -250.0; };
        o.depth = 1;
        return o;
    }());
    return repository;
}

}  // namespace carat::test
