#include "carat/vulkan/atmosphere.hpp"

#include <cmath>

#include "carat/globe/error.hpp"

namespace carat {

namespace {

void require(bool good, const char* what) {
    if (!good) throw Error(ErrorCode::usage, std::string("atmosphere: ") + what);
}

bool coefficients(const std::array<double, 3>& c) {
    for (const double x : c)
        if (!(x >= 0 && x <= 1)) return false;
    return true;
}

bool length(double x) { return x > 0 && x < 1e12; }

}  // namespace

std::optional<Atmosphere> atmosphere_of(const std::string& body) {
    Atmosphere air;
    if (body == "earth") {
        air.rayleigh = {5.802e-6, 13.558e-6, 33.1e-6};
        air.mie_scattering = {3.996e-6, 3.996e-6, 3.996e-6};
        air.mie_absorption = {4.40e-6, 4.40e-6, 4.40e-6};
        air.absorption = {0.650e-6, 1.881e-6, 0.085e-6};
        return air;
    }
    if (body == "mars") {
        constexpr double kDust = 0.5 / 11e3;  // optical depth over scale height
        air.rayleigh = {0.12e-6, 0.27e-6, 0.66e-6};
        air.rayleigh_height = air.mie_height = 11e3;
        air.mie_scattering = {0.97 * kDust, 0.92 * kDust, 0.77 * kDust};
        air.mie_absorption = {0.03 * kDust, 0.08 * kDust, 0.23 * kDust};
        air.mie_asymmetry = 0.7;
        air.ground_albedo = 0.2;
        air.sun_angular_radius = 0.00305;
        return air;
    }
    return std::nullopt;
}

void check_atmosphere(const Atmosphere& air) {
    require(coefficients(air.rayleigh) && coefficients(air.mie_scattering) &&
                coefficients(air.mie_absorption) && coefficients(air.absorption),
            "coefficients must be from 0 to 1 per metre");
    require(length(air.rayleigh_height) && length(air.mie_height) && length(air.absorption_half_width) &&
                length(air.top),
            "scale heights, the absorber's half width and the top must be positive");
    require(std::abs(air.mie_asymmetry) < 1, "the asymmetry must be between -1 and 1");
    require(std::isfinite(air.absorption_middle), "the absorber's middle must be finite");
    require(air.ground_albedo >= 0 && air.ground_albedo <= 1, "the ground's albedo must be from 0 to 1");
    require(air.sun_angular_radius > 0 && air.sun_angular_radius <= 0.1,
            "the sun's angular radius must be from 0 to 0.1 radians");
}

}  // namespace carat
