#include "plane_rim.hpp"

#include <algorithm>
#include <array>
#include <numeric>

namespace carat::bench {
namespace {

int floor_div(int a, int b) { return a / b - (a % b < 0 ? 1 : 0); }

std::size_t vertex(int i, int j) { return static_cast<std::size_t>(i * kPlaneN + j); }

}  // namespace

void Columns::clip(int first, int step, int most) {
    if (step == 0) {
        if (first < 0 || first > most) end = begin;
    } else if (step > 0) {
        begin = std::max(begin, -floor_div(first, step));
        end = std::min(end, floor_div(most - first, step) + 1);
    } else {
        begin = std::max(begin, -floor_div(most - first, -step));
        end = std::min(end, floor_div(first, -step) + 1);
    }
}

Columns columns_inside(const PixelFrame& f, const PlanePlan& plan, int i, int first) {
    const int p = 2 * i + first;
    Columns c{0, kPlaneN - first};
    c.clip(f.x + p * f.ux + first * f.vx, 2 * f.vx, 2 * (plan.width - 1));
    c.clip(f.y + p * f.uy + first * f.vy, 2 * f.vy, 2 * (plan.height - 1));
    return c;
}

void fill_outside(const PlaneStep& step, const PlanePlan& plan, std::vector<std::int32_t>& p) {
    std::array<Columns, kPlaneN> rows;
    std::int64_t sum = 0, count = 0;
    for (int i = 0; i < kPlaneN; ++i) {
        Columns& c = rows[static_cast<std::size_t>(i)] = columns_inside(step.frame, plan, i, 0);
        if (c.empty()) c = {0, 0};
        sum = std::accumulate(p.data() + vertex(i, c.begin), p.data() + vertex(i, c.end), sum);
        count += c.end - c.begin;
    }
    const auto mean = static_cast<std::int32_t>(count == 0 ? 0 : sum / count);
    for (int i = 0; i < kPlaneN; ++i) {
        const Columns& c = rows[static_cast<std::size_t>(i)];
        std::fill(p.data() + vertex(i, 0), p.data() + vertex(i, c.begin), mean);
        std::fill(p.data() + vertex(i, c.end), p.data() + vertex(i, kPlaneN), mean);
    }
}

}  // namespace carat::bench
