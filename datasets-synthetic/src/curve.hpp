// A smooth monotone curve through given points (Fritsch and Carlson 1980), for hypsometry.
#pragma once

#include <vector>

#include "dual.hpp"

namespace carat::synth {

class Curve {
  public:
    struct Knot {
        double x;
        double y;
    };
    explicit Curve(std::vector<Knot> knots);
    /// Value and chain rule; constant beyond the ends.
    Dual operator()(const Dual& x) const noexcept;

  private:
    std::vector<Knot> knots_;
    std::vector<double> slopes_;
};

}  // namespace carat::synth
