// The interpolation of deep patches: its constants, and that its error stays below the bound.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <numbers>

#include "position_fit.hpp"

namespace carat::test {
namespace {

using Complex = std::complex<double>;
constexpr double kPi = std::numbers::pi;
// Radians: nodes lie beyond a face's edge by less than a leg of level 11.
constexpr double kBeyond = kPi / 2 / 64;

// a over the root in A (position_fit.hpp) at face angles, for semi-axes 1 and b, on a polar or an equatorial
// face. That of T for b = 1.
Complex length_share(bool polar, double b, Complex phi, Complex psi) {
    const Complex u = std::tan(phi), v = std::tan(psi);
    return 1.0 / std::sqrt(polar ? u * u + v * v + b * b : 1.0 + u * u + b * b * v * v);
}

// |f^(n)/n!| for the n of kFitOrders, along a line through a place: Cauchy's integrals over a circle, whose
// trapezoidal sums err by the coefficients 32 further on.
std::array<double, 4> taylor_at(bool polar, double b, double phi, double psi, double along_u,
                                double along_v) {
    constexpr int kPoints = 32;
    const double radius = 0.1 * b;
    std::array<Complex, 4> sum{};
    for (int k = 0; k < kPoints; ++k) {
        const double turn = 2 * kPi * k / kPoints;
        const Complex z = std::polar(radius, turn);
        const Complex f = length_share(polar, b, phi + along_u * z, psi + along_v * z);
        for (std::size_t m = 0; m < sum.size(); ++m) sum[m] += f * std::polar(1.0, -turn * kFitOrders[m].n);
    }
    std::array<double, 4> out{};
    for (std::size_t m = 0; m < out.size(); ++m)
        out[m] = std::abs(sum[m]) / kPoints / std::pow(radius, kFitOrders[m].n);
    return out;
}

TEST(PositionFit, TaylorCoefficientsAreBelowTheirBounds) {
    constexpr int kPlaces = 24;
    std::array<double, 4> share{};
    for (const double b : {1.0, 0.99, 0.9, 0.7, 0.5, 0.3, 0.1})
        for (const bool polar : {false, true})
            for (int i = 0; i <= kPlaces; ++i)
                for (int j = 0; j <= kPlaces; ++j) {
                    const double phi = (kPi / 4 + kBeyond) * i / kPlaces,
                                 psi = (kPi / 4 + kBeyond) * j / kPlaces;
                    for (const auto& [u, v] : {std::pair{1, 0}, {0, 1}, {1, 1}, {1, -1}}) {
                        const std::array<double, 4> taylor = taylor_at(polar, b, phi, psi, u, v);
                        for (std::size_t m = 0; m < share.size(); ++m)
                            share[m] = std::max(share[m], taylor[m] * std::pow(b, kFitOrders[m].n + 1) /
                                                              kFitOrders[m].taylor);
                    }
                }
    for (const double s : share) {
        EXPECT_LE(s, 1);
        EXPECT_GT(s, 0.9) << "the bound is lazy";
    }
}

TEST(PositionFit, NodesAreAsGoodAsTheySay) {
    for (const FitOrder& order : kFitOrders) {
        double nodal = 0, lebesgue = 0;
        for (int k = -2000; k <= 2000; ++k) {
            const double x = k / 2000.0;
            double product = 1, sum = 0;
            for (int i = 0; i < order.n; ++i) {
                const double own = order.node[static_cast<std::size_t>(i)] / 128.0;
                product *= x - own;
                double polynomial = 1;
                for (int j = 0; j < order.n; ++j) {
                    const double other = order.node[static_cast<std::size_t>(j)] / 128.0;
                    if (j != i) polynomial *= (x - other) / (own - other);
                }
                sum += std::abs(polynomial);
            }
            nodal = std::max(nodal, std::abs(product));
            lebesgue = std::max(lebesgue, sum);
        }
        EXPECT_LE(nodal, order.nodal) << order.n;
        EXPECT_LE(lebesgue, order.lebesgue) << order.n;
        EXPECT_GT(nodal, 0.98 * order.nodal);
        EXPECT_GT(lebesgue, 0.99 * order.lebesgue);
    }
}

// Each order takes over where it is accurate enough, and the deeper the fewer nodes.
TEST(PositionFit, OrdersFollowLevels) {
    for (const Ellipsoid& body : {Ellipsoid::earth(), Ellipsoid(1000, 900), Ellipsoid(1e6, 1e5)}) {
        int before = 99;
        for (int level = 0; level <= kDeepestId; ++level) {
            const FitOrder* const order = fit_order(body, level);
            EXPECT_TRUE(level > 10 || order == nullptr) << "nodes lie further beyond the face than kBeyond";
            if (order == nullptr) {
                EXPECT_EQ(before, 99);
                continue;
            }
            EXPECT_LE(fit_error(body, level, *order), kFitTolerance);
            EXPECT_LE(order->n, before);
            before = order->n;
        }
        EXPECT_EQ(before, 4);
    }
}

}  // namespace
}  // namespace carat::test
