// Prints where a place lies on the Earth and in the lattice; fails unless going there and back agrees.
#include <carat/globe/globe.hpp>
#include <cmath>
#include <cstdio>

int main() {
    const carat::Ellipsoid earth = carat::Ellipsoid::earth();
    const carat::Geodetic place{46.5475, 7.9854};
    const double height = 3463;

    const carat::Vec3 position = earth.position(carat::direction(place), height);
    const auto back = earth.normal_height(position);
    const carat::Geodetic again = carat::geodetic(back.normal);
    std::printf("%.4f %.4f at %.0f m lies at %.3f %.3f %.3f m\n", place.latitude, place.longitude, height,
                position[0], position[1], position[2]);
    std::printf("the diamond of the +x face is %s\n", to_string(carat::root_diamond(0)).c_str());

    const bool same = std::abs(again.latitude - place.latitude) < 1e-9 &&
                      std::abs(again.longitude - place.longitude) < 1e-9 &&
                      std::abs(back.height - height) < 1e-6;
    return same ? 0 : 1;
}
