// Positions of a deep patch's inner vertices by polynomials instead of roots.
//
// A vertex is at w times (A + h T), or times (A b^2/a^2 + h T) along the polar axis, with
//     A = a^2 / (u sqrt(a^2 (wx^2 + wy^2) + b^2 wz^2)),    T = 1 / (u |w|)
// (vertex_position.hpp), and A and T are smooth functions of the two face angles. Over the square that a
// half's rows and columns span they are interpolated once, on n x n nodes near Chebyshev's, where its
// vertices take polynomials of n coefficients. Vertices that patches share, a half's border, stay as
// vertex_position() has them.
//
// Error. Interpolating f at n nodes of an interval of half-length l errs by at most max|f^(n)/n!| l^n
// max|prod(x - x_i)| (x over [-1, 1]); in both directions, one after the other, (1 + Lebesgue constant) times
// that. In units of the semi-axis a, |f^(n)/n!| <= K_n (a/b)^(n+1) for A, and at most K_n for T; a step along
// a row or column moves each face angle by as much as l or not at all. |w| <= sqrt(3) on a face. So for
// |h| <= a
//     |p - p'| <= 2 sqrt(3) (1 + Lebesgue) K_n (a/b)^(n+1) max|prod| l^n a/u.
// K_n: sampled over the faces of bodies with a/10 <= b <= a (tests/render/cut).
#pragma once

#include <array>
#include <cstddef>

#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"

namespace carat {

// Numbers of nodes in use, and what the error takes of them.
struct FitOrder {
    int n = 0;
    double taylor = 0;          // K_n
    double nodal = 0;           // greatest |product of (x - x_i)| over [-1, 1]
    double lebesgue = 0;        // greatest sum of |Lagrange polynomials| there
    std::array<int, 8> node{};  // in 1/128, so that nodes are exact
};
inline constexpr std::array<FitOrder, 4> kFitOrders{
    {{4, 2.3, 0.1282, 1.875, {-118, -49, 49, 118}},
     {5, 1.6, 0.0640, 1.944, {-122, -75, 0, 75, 122}},
     {6, 4.6, 0.0323, 1.996, {-124, -91, -33, 33, 91, 124}},
     {8, 9.5, 0.0087, 2.042, {-126, -106, -71, -25, 25, 71, 106, 126}}}};

// Length units: what interpolation may cost. With the rounding of sums below kPositionRounding.
inline constexpr double kFitTolerance = 0.005;

// The bound above for halves of that level, length units.
double fit_error(const Ellipsoid& body, int level, const FitOrder& order);
// The first whose error is within kFitTolerance; null: none.
const FitOrder* fit_order(const Ellipsoid& body, int level);

// The polynomials of a half, column by column.
struct PositionFit {
    static constexpr std::size_t kColumns = 129 + 15, kMostCoefficients = 8;
    using Coefficients = std::array<std::array<double, kColumns>, kMostCoefficients>;

    int coefficients = 0;
    double flattening = 1;           // b^2 / a^2
    Coefficients surface{};          // [k][c]: of A in column c, times rows[r]^k; length units
    Coefficients normal{};           // of T; length units a metre
    std::array<double, 129> rows{};  // 2r/cells - 1
};
// cells a power of two, at most 128.
void fit_positions(const Ellipsoid& body, const Half& half, int cells, const FitOrder& order,
                   PositionFit& out);

}  // namespace carat
