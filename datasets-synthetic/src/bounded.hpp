#pragma once

namespace carat::synth {

/// Identity up to `knee`, then bending smoothly towards `limit`, which is never reached. knee < limit.
constexpr double bounded(double h, double knee, double limit) noexcept {
    const double over = (h - knee) / (limit - knee);
    return over <= 0 ? h : knee + (limit - knee) * over / (1 + over);
}

}  // namespace carat::synth
