// consumer FILE LAT LON HEIGHT: opens a .carat file through the installed libraries, evaluates its surface at
// a place, and fails unless the height is the one that `carat query` gave (metres, to the millimetre that it
// prints).
#include <carat/codec/repository.hpp>
#include <carat/codec/surface.hpp>
#include <carat/globe/globe.hpp>
#include <cmath>
#include <cstdio>
#include <cstdlib>

int main(int argc, char** argv) {
    if (argc != 5) return 2;
    const carat::Geodetic place{std::atof(argv[2]), std::atof(argv[3])};
    const double expected = std::atof(argv[4]);

    const carat::Surface surface(carat::Repository::open(argv[1]));
    const double height = surface.sample(carat::lattice_position(carat::direction(place))).height;
    std::printf("%.4f %.4f lies at %.3f m; carat query says %.3f m\n", place.latitude, place.longitude,
                height, expected);
    return std::abs(height - expected) < 0.002 ? 0 : 1;
}
