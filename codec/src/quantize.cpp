#include "carat/codec/quantize.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "carat/globe/error.hpp"

namespace carat {

std::int32_t quantizer_radius(double tolerance, double quantum) {
    if (!std::isfinite(tolerance) || !std::isfinite(quantum) || !(quantum > 0) || !(tolerance >= quantum / 2))
        throw Error(ErrorCode::usage, "tolerance " + std::to_string(tolerance) +
                                          " m must be at least half the quantum " + std::to_string(quantum) +
                                          " m");
    double r = std::floor(tolerance / quantum - 0.5);
    if (r > (1 << 29)) throw Error(ErrorCode::limit, "tolerance exceeds 2^29 quanta");
    // The division rounds: make the stated inequality true of the doubles themselves.
    while (r > 0 && r * quantum + quantum / 2 > tolerance) --r;
    return static_cast<std::int32_t>(r);
}

double default_quantum(double tolerance) {
    return std::exp2(std::floor(std::log2(std::min(1.0 / 256, tolerance / 8))));
}

}  // namespace carat
