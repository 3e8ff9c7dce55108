// What the air of a body is made of, for drawing the sky.
#pragma once

#include <array>
#include <optional>
#include <string>

namespace carat {

// Coefficients are per metre, for linear red, green and blue (680, 550 and 440 nm).
struct Atmosphere {
    // Molecules and aerosols thin out exponentially with height.
    std::array<double, 3> rayleigh{};  // scattering at the ground
    double rayleigh_height = 8000;     // metres, > 0
    std::array<double, 3> mie_scattering{}, mie_absorption{};
    double mie_height = 1200;    // metres, > 0
    double mie_asymmetry = 0.8;  // (-1, 1); phase function of Cornette and Shanks 1992
    // A layer that only absorbs: full in its middle, nothing beyond its half width.
    std::array<double, 3> absorption{};
    double absorption_middle = 25e3, absorption_half_width = 15e3;  // metres, the latter > 0
    double top = 100e3;                                             // metres above the ellipsoid, > 0
    double ground_albedo = 0.3;           // [0, 1], for light scattered more than once
    bool multiple_scattering = true;      // as an isotropic source (Hillaire 2020); off: single scattering
    double sun_angular_radius = 0.00465;  // radians, (0, 0.1]
};

// Earth: Bruneton and Neyret 2008 as Hillaire 2020 uses them, ozone included. Mars: dust of optical depth 0.5
// with the single scattering albedo of Wolff et al. 2009 (0.97, 0.92, 0.77), scale height 11 km, over thin
// carbon dioxide. None for other bodies: their sky is black.
std::optional<Atmosphere> atmosphere_of(const std::string& body);

// Throws Error(usage) if a value is out of range or not finite.
void check_atmosphere(const Atmosphere& air);

}  // namespace carat
