#include "carat/render/visibility.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "carat/globe/patch.hpp"
#include "carat/render/vector.hpp"
#include "half_kernel.hpp"
#include "tangent_table.hpp"

namespace carat {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Least u . (p - eye) over the volume, u a unit vector.
double least_along(const Vec3& u, const Vec3& eye, const HalfVolume& volume) {
    double least = kInfinity;
    for (const Vec3& p : volume.points) least = std::min(least, dot(u, subtract(p, eye)));
    return least - volume.slack;
}

// Lower bound of the distance from the eye to the volume: the distance to a plane that separates them.
double least_distance(const Vec3& eye, const HalfVolume& volume) {
    const Vec3 to_half = subtract(volume.points[0], eye);
    const double away = length(to_half);
    double distance = std::max(0.0, least_along(scale(-1, volume.outwards), eye, volume));
    if (away > 0) distance = std::max(distance, least_along(scale(1 / away, to_half), eye, volume));
    return distance;
}

// Cosine of the greatest angle off the axis in the volume, and of that of the image corners where they are
// nearer or not all of the volume lies before the eye. The cone of a given half-angle below 90 degrees is
// convex, so it contains the hull if it contains the (widened) points: angle(v) + asin(slack / |v|) by the
// addition theorem, without a trigonometric call.
double least_cosine(const View& view, double corner_cosine, const HalfVolume& volume) {
    double cosine = 1;
    for (const Vec3& p : volume.points) {
        const Vec3 v = view.to_screen_axes(p);
        const double square = dot(v, v), away = square - volume.slack * volume.slack;
        if (v[2] <= volume.slack || away <= 0) return corner_cosine;
        const double across = std::sqrt(v[0] * v[0] + v[1] * v[1]);
        cosine = std::min(cosine, (v[2] * std::sqrt(away) - across * volume.slack) / square);
    }
    return std::max(cosine, corner_cosine);
}

// Of the points of a half's grid of HalfVolume::kCells in storage order, one coordinate; the rest 1.
void grid_tangents(const HalfFrame& frame, int side, int axis, Places::value_type& out) {
    constexpr double kScale = 1.0 / static_cast<double>(kLatticeExtent);
    const std::int64_t along_row = side == 0 ? frame.u[axis] : frame.v[axis],
                       along_column = side == 0 ? frame.v[axis] : frame.u[axis];
    out.fill(1);
    std::size_t k = 0;
    for (int r = 0; r <= HalfVolume::kCells; ++r)
        for (int c = 0; c <= r; ++c, ++k)
            out[k] = static_cast<double>(frame.origin[axis] + r * along_row + c * along_column) * kScale;
    // The face's own coordinate is 1 or -1 everywhere.
    if (along_row != 0 || along_column != 0) tangents_in_place(out);
}

}  // namespace

// Over a triangle of the grid, ellipsoid point and normal are their linear interpolation up to the sagittas
// of curvature_bound(). So E(x) + h n(x) is within `slack` of a mean of the points E_i + h n_i, and these lie
// between E_i + min n_i and E_i + max n_i. The hull is convex: it contains flat triangles between its points.
HalfShape::HalfShape(const Ellipsoid& body, const Half& half)
    : curvature_(curvature_bound(body, half, HalfVolume::kCells)) {
    Places w{}, normals{}, ground{};
    static_assert(std::tuple_size_v<Places::value_type> >= HalfVolume::kPoints / 2);
    const HalfFrame frame = half_frame(half, HalfVolume::kCells);
    for (int axis = 0; axis < 3; ++axis)
        grid_tangents(frame, half.side, axis, w[static_cast<std::size_t>(axis)]);
    normals_and_ground(body, w, normals, ground);
    for (std::size_t k = 0; k < ground_.size(); ++k) {
        normals_[k] = {normals[0][k], normals[1][k], normals[2][k]};
        ground_[k] = {ground[0][k], ground[1][k], ground[2][k]};
    }
}

HalfVolume HalfShape::volume(double min_height, double max_height, double margin) const {
    HalfVolume volume;
    for (std::size_t k = 0; k < ground_.size(); ++k) {
        volume.points[2 * k] = add(ground_[k], scale(min_height, normals_[k]));
        volume.points[2 * k + 1] = add(ground_[k], scale(max_height, normals_[k]));
    }
    volume.outwards = normals_[half_vertex_index(3, 1)];
    const double highest = std::max(std::abs(min_height), std::abs(max_height));
    volume.slack = curvature_.ellipsoid_sagitta + curvature_.normal_sagitta * highest + margin;
    return volume;
}

CurvatureBound HalfShape::curvature(int cells) const {
    const double finer = static_cast<double>(HalfVolume::kCells) / cells;  // exact, as are the products
    return {curvature_.ellipsoid_sagitta * finer * finer, curvature_.normal_sagitta * finer * finer,
            curvature_.normal_change * finer};
}

HalfVolume half_volume(const Ellipsoid& body, const Half& half, double min_height, double max_height,
                       double margin) {
    return HalfShape(body, half).volume(min_height, max_height, margin);
}

// The lowered ellipsoid. S lies outside the body's parallel surface at depth m = -min_height, whose support
// function is s(n) - m, s(n) = sqrt(a^2 nx^2 + a^2 ny^2 + b^2 nz^2) >= b. The body scaled by k = 1 - m/b has
// support k s(n) = s(n) - m s(n)/b <= s(n) - m: it lies inside.
//
// What hides the far side is not S but the patches drawn, whose error is at most the margin T in pixels: at
// distance t they lie below S by at most T t / f. Nothing unhidden is further than t_max, from the eye to the
// horizon and on to the highest summit behind it. So m also holds D = T t_max(m) / f. t_max grows with m;
// iterating from above, from a t_max that no lowering exceeds, every iterate is a valid D.
Visibility::Visibility(const View& view, const Ellipsoid& body, double min_height, double max_height,
                       double margin_pixels)
    : view_(view), body_(body), corner_cosine_(std::cos(view.corner_angle())) {
    const double a = body.a(), b = body.b(), eye = length(view.eye());
    const double summit = a + std::max(0.0, max_height), lowest = std::max(0.0, -min_height);
    const auto tangent = [](double from, double radius) {
        return std::sqrt(std::max(0.0, from * from - radius * radius));
    };
    double furthest = eye + summit;
    for (int k = 0; k < 8; ++k) {
        horizon_depth_ = lowest + margin_pixels * furthest / view.focal_pixels();
        const double radius = std::max(0.0, b - horizon_depth_);  // of a ball inside the lowered ellipsoid
        furthest = std::min(furthest, tangent(eye, radius) + tangent(summit, radius));
    }
    const double shrink = 1 - horizon_depth_ / b;
    if (!(shrink > 0)) return;
    horizon_scale_ = {1 / (shrink * a), 1 / (shrink * a), 1 / (shrink * b)};
    horizon_slack_ = horizon_scale_[2];
    for (std::size_t k = 0; k < 3; ++k) horizon_eye_[k] = horizon_scale_[k] * view.eye()[k];
    horizon_distance_ = length(horizon_eye_);
    has_horizon_ = horizon_distance_ > 1;  // an eye inside sees everything
    if (!has_horizon_) return;
    horizon_axis_ = scale(1 / horizon_distance_, horizon_eye_);
    cone_sine_ = 1 / horizon_distance_;
    cone_cosine_ = std::sqrt((1 - cone_sine_) * (1 + cone_sine_));
}

Culled Visibility::cull(const HalfVolume& volume) const {
    if (outside_frustum(volume)) return Culled::frustum;
    if (has_horizon_ && below_horizon(volume)) return Culled::horizon;
    return Culled::none;
}

bool Visibility::outside_frustum(const HalfVolume& volume) const {
    const auto beyond = [&](const Vec3& inward) {
        for (const Vec3& p : volume.points)
            if (dot(inward, subtract(p, view_.eye())) >= -volume.slack) return false;
        return true;
    };
    return beyond(view_.camera().forward) ||
           std::any_of(view_.side_planes().begin(), view_.side_planes().end(), beyond);
}

// With the lowered ellipsoid scaled to the unit sphere and the eye at V, a point X with X . V < 1 inside the
// cone of tangents from V is hidden: its line of sight crosses the plane X . V = 1 within the circle of
// tangency, which lies in the sphere. Half-space and cone are convex, so they contain the hull if they
// contain every point with its slack, a ball that scaling turns into one of at most slack / (k b).
bool Visibility::below_horizon(const HalfVolume& volume) const {
    const double slack = volume.slack * horizon_slack_ + 1e-14;
    for (const Vec3& p : volume.points) {
        Vec3 x{};
        for (std::size_t k = 0; k < 3; ++k) x[k] = horizon_scale_[k] * p[k];
        const double along = dot(x, horizon_axis_);
        if (along + slack >= 1 / horizon_distance_) return false;
        const double across = length(subtract(x, scale(along, horizon_axis_)));
        if ((horizon_distance_ - along) * cone_sine_ - across * cone_cosine_ <= slack) return false;
    }
    return true;
}

// X = (x, z) on screen, x the two transverse components, Y = X + (v, w). Then
//     f |Y'/Y_z - x/z| = f |v - w x/z| / Y_z <= f |(v, w)| sqrt(1 + |x/z|^2) / Y_z <= f delta sec(theta_X) /
//     Y_z.
// X is on screen, so theta_X is at most the corner angle and z >= |X - eye| cos(corner angle). Y is in the
// volume and within delta of X. Exact, not a first-order estimate, and symmetric in which of the two is
// drawn.
double Visibility::screen_error(const HalfVolume& volume, double delta) const {
    const double z_volume = least_along(view_.camera().forward, view_.eye(), volume);
    const double z_on_screen = std::max(z_volume, least_distance(view_.eye(), volume) * corner_cosine_);
    if (z_on_screen <= delta) return kInfinity;
    const double z_other = std::max(z_volume, z_on_screen - delta);
    return view_.focal_pixels() * delta / (least_cosine(view_, corner_cosine_, volume) * z_other);
}

double Visibility::screen_spacing(const HalfVolume& volume, double spacing) const {
    const double distance = least_distance(view_.eye(), volume);
    return distance > 0 ? view_.focal_pixels() * spacing / distance : kInfinity;
}

}  // namespace carat
