// Latitudes and longitudes of the vertices of a half, with most of the trigonometry in tables.
//
// A component of a lattice point's coordinates takes at most 2 cells + 1 values within a half, so its
// tangents are worked out once each; on the faces across x and y the longitude depends on one of them alone.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <vector>

#include "carat/globe/diamond.hpp"
#include "carat/globe/sphere.hpp"

namespace carat {

// Degrees of the direction of three tangents, of any length. Exact at the poles.
inline double latitude_of_tangents(const Vec3& w) {
    return std::atan(w[2] / std::sqrt(w[0] * w[0] + w[1] * w[1])) * (180 / std::numbers::pi);
}
inline double longitude_of_tangents(double x, double y) {
    return std::atan2(y + 0.0, x) * (180 / std::numbers::pi);  // + 0.0: no -0, so no longitude -180
}

class HalfDegrees {
  public:
    HalfDegrees(const Half& half, int cells) {
        const HalfFrame frame = half_frame(half, cells);
        const std::array<std::array<int, 2>, 3> corners{
            {{0, 0}, {cells, cells}, {half.side == 0 ? cells : 0, half.side == 0 ? 0 : cells}}};
        for (int k = 0; k < 3; ++k) {
            Axis& axis = axes_[static_cast<std::size_t>(k)];
            const std::int64_t step = std::max(std::abs(frame.u[k]), std::abs(frame.v[k]));
            axis.i = step == 0 ? 0 : static_cast<int>(frame.u[k] / step);
            axis.j = step == 0 ? 0 : static_cast<int>(frame.v[k] / step);
            int low = 0, high = 0;
            for (const auto& [i, j] : corners) {
                low = std::min(low, i * axis.i + j * axis.j);
                high = std::max(high, i * axis.i + j * axis.j);
            }
            axis.first = low;
            for (int t = low; t <= high; ++t)
                axis.tangent.push_back(
                    lattice_tangent(static_cast<std::int32_t>(frame.origin[k] + t * step)));
        }
        if (axes_[0].constant())
            tabulate(1, [&](double y) { return longitude_of_tangents(axes_[0].tangent[0], y); });
        else if (axes_[1].constant())
            tabulate(0, [&](double x) { return longitude_of_tangents(x, axes_[1].tangent[0]); });
    }

    // Vertices (i, begin) to (i, end - 1).
    void row(int i, int begin, int end, double* lat, double* lon) const {
        for (int j = begin; j < end; ++j) {
            const Vec3 w{axes_[0].at(i, j), axes_[1].at(i, j), axes_[2].at(i, j)};
            *lat++ = latitude_of_tangents(w);
            *lon++ = longitude_axis_ < 0
                         ? longitude_of_tangents(w[0], w[1])
                         : longitude_[axes_[static_cast<std::size_t>(longitude_axis_)].index(i, j)];
        }
    }

  private:
    struct Axis {
        int i = 0, j = 0, first = 0;
        std::vector<double> tangent;

        bool constant() const { return tangent.size() == 1; }
        std::size_t index(int row, int column) const {
            return static_cast<std::size_t>(row * i + column * j - first);
        }
        double at(int row, int column) const { return tangent[index(row, column)]; }
    };
    template <class F>
    void tabulate(int axis, F longitude) {
        longitude_axis_ = axis;
        for (const double t : axes_[static_cast<std::size_t>(axis)].tangent)
            longitude_.push_back(longitude(t));
    }

    std::array<Axis, 3> axes_;
    std::vector<double> longitude_;
    int longitude_axis_ = -1;
};

}  // namespace carat
