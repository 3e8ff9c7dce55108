// Light, colour and samples: options that render and fly share.
#pragma once

#include <CLI/App.hpp>
#include <array>
#include <memory>
#include <optional>
#include <string>

#include "carat/codec/colour.hpp"
#include "carat/render/detail.hpp"
#include "carat/render/view.hpp"
#include "carat/vulkan/renderer.hpp"

namespace carat::cli {

struct Look {
    std::array<double, 3> background{};        // sRGB, 0 to 255
    std::optional<std::array<double, 2>> sun;  // azimuth, elevation seen from the eye, degrees
    std::string time;                          // UTC; empty: the sun stands still
    std::string color;                         // a colour file to drape; empty: none
    std::string colours;                       // a body's name or a file; empty: those of the body
    std::optional<double> relief;              // factor on slopes, for shading
    Tone tone = Tone::none;                    // of 8-bit pictures
    Light light;
    std::optional<double> ambient;  // share of light from everywhere
    bool sky = false, water = false;
    double wind = 5;  // m/s
    int samples = 4;
    int supersample = 1;                  // pixels either way, drawn for one
    std::optional<DetailOptions> detail;  // procedural, below the file's samples
};

// --colors; null where none are asked for. Throws what read_colours() throws.
std::optional<ColourTable> chosen_colours(const Look& look);

// --color; null without. Throws what ColourRepository::open() throws.
std::shared_ptr<const ColourRepository> draped_colours(const Look& look);

// --detail; null without. Throws what Detail's constructor throws.
std::shared_ptr<const Detail> detail_of(const Look& look, const RepositoryHeader& header);

// --detail [LIST], alone.
void add_detail_option(CLI::App& sub, std::optional<DetailOptions>& detail, const char* group);
void add_look_options(CLI::App& sub, Look& look);

// What is drawn for `where`: with more pixels, if they are to be averaged (shrunk()).
ViewRequest drawn_view(const Look& look, ViewRequest where);

// What to draw, AOVs aside. Throws Error(usage) for values out of range.
DrawRequest draw_request(const Look& look, const ViewRequest& where, const View& view, const Ellipsoid& body);

}  // namespace carat::cli
