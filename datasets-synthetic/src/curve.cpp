#include "curve.hpp"

#include <utility>

namespace carat::synth {

Curve::Curve(std::vector<Knot> knots) : knots_(std::move(knots)), slopes_(knots_.size(), 0.0) {
    const auto secant = [&](std::size_t i) {
        return (knots_[i + 1].y - knots_[i].y) / (knots_[i + 1].x - knots_[i].x);
    };
    // The harmonic mean of the neighbouring secants keeps the curve monotone; the ends are level.
    for (std::size_t i = 1; i + 1 < knots_.size(); ++i) {
        const double a = secant(i - 1), b = secant(i);
        slopes_[i] = a * b > 0 ? 2 * a * b / (a + b) : 0;
    }
}

Dual Curve::operator()(const Dual& x) const noexcept {
    if (x.v <= knots_.front().x) return knots_.front().y;
    if (x.v >= knots_.back().x) return knots_.back().y;
    std::size_t i = 0;
    while (x.v > knots_[i + 1].x) ++i;
    const Knot &a = knots_[i], &b = knots_[i + 1];
    const double w = b.x - a.x, t = (x.v - a.x) / w;
    const double c2 = 3 * (b.y - a.y) - w * (2 * slopes_[i] + slopes_[i + 1]);
    const double c3 = 2 * (a.y - b.y) + w * (slopes_[i] + slopes_[i + 1]);
    const double y = a.y + t * (w * slopes_[i] + t * (c2 + t * c3));
    return chain(x, y, (w * slopes_[i] + t * (2 * c2 + 3 * t * c3)) / w);
}

}  // namespace carat::synth
