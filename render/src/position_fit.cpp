#include "position_fit.hpp"

#include <cmath>
#include <cstdint>
#include <numbers>

#include "carat/render/patch_mesh.hpp"

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "position_fit.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

#ifndef CARAT_POSITION_FIT_ONCE
#define CARAT_POSITION_FIT_ONCE
namespace carat {

constexpr std::size_t kMostNodes = PositionFit::kMostCoefficients;
using FitMatrix = std::array<std::array<double, kMostNodes>, kMostNodes>;

// Nodes, as shares of a leg, and of the Lagrange polynomial of node i over [-1, 1] the coefficient of x^k:
// powers[k][i].
struct Lagrange {
    std::array<double, kMostNodes> share{};
    FitMatrix powers{}, transposed{};
};

// x = origin + share along_row + share along_column; 1 at a cube edge.
struct FitAxis {
    double origin = 0, along_row = 0, along_column = 0;
};

struct FitTask {
    int order = 0, cells = 0;
    double a2 = 0, b2 = 0, per_unit = 0;
    std::array<FitAxis, 3> axes{};
    const Lagrange* lagrange = nullptr;
};

}  // namespace carat
#endif

HWY_BEFORE_NAMESPACE();
namespace carat::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

#include "vertex_lanes.inc"

static_assert(kMostNodes % hn::MaxLanes(D()) == 0);

// tan(pi/4 x) on a face and a little beyond: tan(pi/4 (2 - x)) is its inverse.
HWY_INLINE V tangent_around(V x) {
    const D d;
    const V one = hn::Set(d, 1.0), size = hn::Abs(x);
    const auto beyond = hn::Gt(size, one);
    const V t = tangent(Lanes{hn::IfThenElse(beyond, hn::Sub(hn::Set(d, 2.0), size), size)}).v;
    const V folded = hn::IfThenElse(beyond, hn::Div(one, t), t);
    return hn::CopySign(hn::IfThenElse(hn::Eq(size, one), one, folded), x);
}

// A and T at the nodes: [i][j] at node i along the rows and node j along the columns.
HWY_INLINE void at_nodes(const FitTask& task, FitMatrix& surface, FitMatrix& normal) {
    const D d;
    const Body<Lanes> body{{hn::Set(d, task.a2)}, {hn::Set(d, task.b2)}, {hn::Set(d, task.per_unit)}};
    const std::array<double, kMostNodes>& share = task.lagrange->share;
    for (std::size_t i = 0; i < static_cast<std::size_t>(task.order); ++i)
        for (std::size_t j = 0; j < static_cast<std::size_t>(task.order); j += hn::Lanes(d)) {
            const auto w = [&](std::size_t axis) HWY_ATTR -> Lanes {
                const FitAxis& x = task.axes[axis];
                const V row = hn::Set(d, x.origin + share[i] * x.along_row);
                if (x.along_column == 0 && x.along_row == 0) return {row};  // the face's axis: 1 or -1
                return {tangent_around(
                    hn::Add(row, hn::Mul(hn::LoadU(d, &share[j]), hn::Set(d, x.along_column))))};
            };
            const Lengths<Lanes> of = lengths(body, w(0), w(1), w(2));
            hn::StoreU((body.a2 * (of.s * body.per_unit)).v, d, &surface[i][j]);
            hn::StoreU((of.t * body.per_unit).v, d, &normal[i][j]);
        }
}

// left right
template <std::size_t kCount>
HWY_INLINE void multiply(const FitMatrix& left, const FitMatrix& right, FitMatrix& out) {
    const D d;
    for (std::size_t j = 0; j < kCount; j += hn::Lanes(d))
        for (std::size_t i = 0; i < kCount; ++i) {
            V sum = hn::Mul(hn::Set(d, left[i][0]), hn::LoadU(d, &right[0][j]));
            for (std::size_t k = 1; k < kCount; ++k)
                sum = hn::Add(sum, hn::Mul(hn::Set(d, left[i][k]), hn::LoadU(d, &right[k][j])));
            hn::StoreU(sum, d, &out[i][j]);
        }
}

// Of values at the nodes; taken relative to the middle one, so that sums round what is small.
template <std::size_t kCount>
HWY_INLINE void by_columns(FitMatrix& values, const FitTask& task, PositionFit::Coefficients& columns) {
    const D d;
    const V middle = hn::Set(d, values[kCount / 2][kCount / 2]);
    for (std::size_t i = 0; i < kCount; ++i)
        for (std::size_t j = 0; j < kCount; j += hn::Lanes(d))
            hn::StoreU(hn::Sub(hn::LoadU(d, &values[i][j]), middle), d, &values[i][j]);
    FitMatrix half, powers;
    multiply<kCount>(task.lagrange->powers, values, half);
    multiply<kCount>(half, task.lagrange->transposed, powers);
    powers[0][0] += hn::GetLane(middle);
    const V step = hn::Set(d, 2.0 / task.cells);
    for (int c = 0; c <= task.cells; c += static_cast<int>(hn::Lanes(d))) {
        const V x = hn::Sub(hn::Mul(hn::Iota(d, c), step), hn::Set(d, 1.0));
        for (std::size_t k = 0; k < kCount; ++k) {
            V sum = hn::Set(d, powers[k][kCount - 1]);
            for (std::size_t m = kCount - 1; m-- > 0;)
                sum = hn::Add(hn::Mul(sum, x), hn::Set(d, powers[k][m]));
            hn::StoreU(sum, d, &columns[k][static_cast<std::size_t>(c)]);
        }
    }
}

template <std::size_t kCount>
HWY_INLINE void fit_with(const FitTask& task, PositionFit& out) {
    FitMatrix surface, normal;
    at_nodes(task, surface, normal);
    by_columns<kCount>(surface, task, out.surface);
    by_columns<kCount>(normal, task, out.normal);
}

void Fit(const FitTask& task, PositionFit& out) {
    switch (task.order) {
        case 4:
            fit_with<4>(task, out);
            break;
        case 5:
            fit_with<5>(task, out);
            break;
        case 6:
            fit_with<6>(task, out);
            break;
        default:
            fit_with<8>(task, out);
    }
}

}  // namespace carat::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace carat {

HWY_EXPORT(Fit);

namespace {

constexpr Lagrange lagrange_of(const FitOrder& order) {
    Lagrange out;
    const auto n = static_cast<std::size_t>(order.n);
    for (std::size_t i = 0; i < n; ++i) {
        out.share[i] = (128 + order.node[i]) / 256.0;
        std::array<double, kMostNodes> product{1};
        double scale = 1;
        std::size_t degree = 0;
        for (std::size_t j = 0; j < n; ++j) {
            if (j == i) continue;
            const double x = order.node[j] / 128.0;
            for (std::size_t k = ++degree; k > 0; --k) product[k] = product[k - 1] - x * product[k];
            product[0] *= -x;
            scale *= order.node[i] / 128.0 - x;
        }
        for (std::size_t k = 0; k < n; ++k) out.transposed[i][k] = out.powers[k][i] = product[k] / scale;
    }
    return out;
}

constexpr std::array<Lagrange, kFitOrders.size()> kLagrange{
    lagrange_of(kFitOrders[0]), lagrange_of(kFitOrders[1]), lagrange_of(kFitOrders[2]),
    lagrange_of(kFitOrders[3])};

}  // namespace

double fit_error(const Ellipsoid& body, int level, const FitOrder& order) {
    // A leg of level 0 is a face's side, pi/2; of level 1 half its diagonal.
    const double half_leg = std::numbers::pi / 4 * std::ldexp(1.0, -((level + 1) / 2));
    return 2 * std::numbers::sqrt3 * (1 + order.lebesgue) * order.taylor *
           std::pow(body.a() / body.b(), order.n + 1) * order.nodal * std::pow(half_leg, order.n) * body.a() /
           length_unit(body);
}

const FitOrder* fit_order(const Ellipsoid& body, int level) {
    for (const FitOrder& order : kFitOrders)
        if (fit_error(body, level, order) <= kFitTolerance) return &order;
    return nullptr;
}

void fit_positions(const Ellipsoid& body, const Half& half, int cells, const FitOrder& order,
                   PositionFit& out) {
    constexpr double kScale = 1.0 / static_cast<double>(kLatticeExtent);
    const HalfFrame frame = half_frame(half, 1);
    const LatticeVector &along_row = half.side == 0 ? frame.u : frame.v,
                        &along_column = half.side == 0 ? frame.v : frame.u;
    FitTask task{order.n, cells, body.a() * body.a(), body.b() * body.b(), 1 / length_unit(body), {}, {}};
    for (int axis = 0; axis < 3; ++axis)
        task.axes[static_cast<std::size_t>(axis)] = {static_cast<double>(frame.origin[axis]) * kScale,
                                                     static_cast<double>(along_row[axis]) * kScale,
                                                     static_cast<double>(along_column[axis]) * kScale};
    task.lagrange = &kLagrange[static_cast<std::size_t>(&order - kFitOrders.data())];
    HWY_DYNAMIC_DISPATCH(Fit)(task, out);
    for (int r = 0; r <= cells; ++r) out.rows[static_cast<std::size_t>(r)] = r * (2.0 / cells) - 1;
    out.coefficients = order.n;
    out.flattening = task.b2 / task.a2;
}

}  // namespace carat
#endif
