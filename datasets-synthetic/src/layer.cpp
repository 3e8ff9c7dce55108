#include "layer.hpp"

#include <numbers>
#include <utility>

namespace carat::synth {

Layer make_layer(std::string name, std::string purpose, std::string truth_text, Grid grid, double spacing_m,
                 Height truth) {
    Layer l{{}, std::move(grid), Damage::none};
    l.info.name = std::move(name);
    l.info.purpose = std::move(purpose);
    l.info.truth_text = std::move(truth_text);
    l.info.width = l.grid.width;
    l.info.height = l.grid.height;
    l.info.bounds = l.grid.bounds();
    l.info.spacing_m = spacing_m;
    l.info.crs = l.grid.crs.definition;
    l.info.truth = std::move(truth);
    return l;
}

double degree_spacing(double step, double radius_m) { return step * std::numbers::pi / 180 * radius_m; }

}  // namespace carat::synth
