// What of a diamond lies inside the raster.
#pragma once

#include <cstdint>
#include <vector>

#include "carat/bench/plane.hpp"

namespace carat::bench {

// A range of columns, [begin, end).
struct Columns {
    int begin, end;

    bool empty() const { return begin >= end; }
    // Leaves those with 0 <= first + j step <= most.
    void clip(int first, int step, int most);
};

// What lies inside the raster of row i of a matrix whose (0, 0) is at doubled index (first, first).
Columns columns_inside(const PixelFrame& f, const PlanePlan& plan, int i, int first);

// Makes all vertices outside the raster the same, so that what nothing is worth there costs little.
void fill_outside(const PlaneStep& step, const PlanePlan& plan, std::vector<std::int32_t>& p);

}  // namespace carat::bench
