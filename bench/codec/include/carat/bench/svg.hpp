// Line plots as small SVG files: both axes logarithmic, a legend at the right.
#pragma once

#include <string>
#include <vector>

namespace carat::bench {

struct PlotSeries {
    std::string name;
    std::vector<double> x, y;  // positive; others are left out
    bool strong = false;       // drawn thick: ours
};

struct Plot {
    std::string title, x_label, y_label;
    std::vector<PlotSeries> series;
};

// One document, the plots side by side.
std::string svg_of(const std::vector<Plot>& plots);

}  // namespace carat::bench
