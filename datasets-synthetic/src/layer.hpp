// What is to be written: a raster with its truth, possibly damaged on purpose.
#pragma once

#include <vector>

#include "carat/synth/synth.hpp"
#include "grid.hpp"

namespace carat::synth {

enum class Damage {
    none,
    empty,       ///< no byte is left
    cut_header,  ///< only the first hundred bytes are left
    cut_data,    ///< the last quarter is gone
};

struct Layer {
    Written info;
    Grid grid;
    Damage damage = Damage::none;
};

/// A layer whose descriptive fields follow from the grid.
Layer make_layer(std::string name, std::string purpose, std::string truth_text, Grid grid, double spacing_m,
                 Height truth);

/// The layers of a kind, in layer order.
std::vector<Layer> earth_layers(const Options& options);
std::vector<Layer> moon_layers(const Options& options);
std::vector<Layer> value_layers(Kind kind, const Options& options);      ///< spikes .. onepixel
std::vector<Layer> placement_layers(Kind kind, const Options& options);  ///< overlap .. rotated
std::vector<Layer> damaged_layers(Kind kind, const Options& options);    ///< empty, truncated

/// Metres from one parallel to the next of a degree grid on a sphere of radius `radius_m`.
double degree_spacing(double step, double radius_m);

}  // namespace carat::synth
