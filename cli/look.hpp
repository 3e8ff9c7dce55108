// Light, colour and samples: options that render and fly share.
#pragma once

#include <CLI/App.hpp>
#include <array>
#include <optional>

#include "carat/render/view.hpp"
#include "carat/vulkan/renderer.hpp"

namespace carat::cli {

struct Look {
    std::array<double, 3> background{};        // sRGB, 0 to 255
    std::optional<std::array<double, 2>> sun;  // azimuth, elevation seen from the eye, degrees
    std::optional<double> relief;              // factor on slopes, for shading
    Light light;
    int samples = 4;
};

void add_look_options(CLI::App& sub, Look& look);

// What to draw, AOVs aside. Throws Error(usage) for values out of range.
DrawRequest draw_request(const Look& look, const ViewRequest& where, const View& view, const Ellipsoid& body);

}  // namespace carat::cli
