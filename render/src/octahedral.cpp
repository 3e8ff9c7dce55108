#include "carat/render/octahedral.hpp"

#include <algorithm>
#include <cmath>

#include "carat/render/vector.hpp"

namespace carat {
namespace {

constexpr double kMax = 32767;

double sign(double x) { return x < 0 ? -1 : 1; }

std::int16_t snorm(double x) { return static_cast<std::int16_t>(std::lround(x * kMax)); }

}  // namespace

std::array<std::int16_t, 2> encode_octahedral(const Vec3& v) {
    const double norm = std::abs(v[0]) + std::abs(v[1]) + std::abs(v[2]);
    const double x = v[0] / norm, y = v[1] / norm;
    if (v[2] >= 0) return {snorm(x), snorm(y)};
    return {snorm((1 - std::abs(y)) * sign(x)), snorm((1 - std::abs(x)) * sign(y))};
}

Vec3 decode_octahedral(const std::array<std::int16_t, 2>& code) {
    const double x = std::max(-1.0, code[0] / kMax), y = std::max(-1.0, code[1] / kMax);
    Vec3 v{x, y, 1 - std::abs(x) - std::abs(y)};
    if (v[2] < 0) v = {(1 - std::abs(y)) * sign(x), (1 - std::abs(x)) * sign(y), v[2]};
    return scale(1 / length(v), v);
}

}  // namespace carat
