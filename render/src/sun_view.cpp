#include "sun_view.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "carat/globe/patch.hpp"
#include "carat/render/vector.hpp"

namespace carat {

SunFrame SunFrame::make(const UnitVector& eye, double unit, const Vec3& sun) {
    const Vec3 aside = std::abs(sun[2]) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
    const Vec3 right = cross(aside, sun);
    SunFrame f{eye, unit, scale(1 / length(right), right), {}, sun};
    f.up = cross(sun, f.right);
    return f;
}

Vec3 SunFrame::from_eye(const PatchMesh& mesh, const PatchVertex& vertex) const {
    UnitVector p;
    for (std::size_t c = 0; c < 3; ++c) p[c] = mesh.anchor[c] - eye[c] + vertex.offset[c];
    return to_metres(p, unit);
}

Vec3 SunFrame::across(const Vec3& p) const { return {dot(right, p), dot(up, p), dot(sun, p)}; }

void SunRectangle::include(const Vec3& p) {
    for (std::size_t k = 0; k < 2; ++k) {
        low[k] = std::min(low[k], p[k]);
        high[k] = std::max(high[k], p[k]);
    }
}

void SunRectangle::grow(double margin) {
    for (int k = 0; k < 2; ++k) {
        low[k] -= margin;
        high[k] += margin;
    }
}

SunView::SunView(const SunFrame& frame, const SunRectangle& where, double cell)
    : frame_(frame),
      low_{where.low[0], where.low[1]},
      cell_(cell),
      width_(static_cast<int>(std::ceil(where.side(0) / cell)) + 1),
      height_(static_cast<int>(std::ceil(where.side(1) / cell)) + 1) {}

Camera SunView::camera(double distance) const {
    const double x = low_[0] + 0.5 * width_ * cell_, y = low_[1] + 0.5 * height_ * cell_;
    const Vec3 centre = add(add(scale(x, frame_.right), scale(y, frame_.up)), scale(distance, frame_.sun));
    const UnitVector offset = to_units(centre, frame_.unit);
    Camera camera;
    for (std::size_t c = 0; c < 3; ++c) camera.eye[c] = frame_.eye[c] + offset[c];
    camera.right = frame_.right;
    camera.up = frame_.up;
    camera.forward = scale(-1, frame_.sun);
    camera.vertical_fov = 2 * std::atan(0.5 * height_ * cell_ / distance);
    camera.width = width_;
    camera.height = height_;
    return camera;
}

int SunView::column(double x, int axis) const {
    const int count = axis == 0 ? width_ : height_;
    return static_cast<int>(
        std::clamp(std::floor((x - low_[axis]) / cell_), -1.0, static_cast<double>(count)));
}

// visit(triangle, span of cells), for those over the rectangle.
template <class Visit>
void SunView::for_triangles(std::size_t mesh, const Visit& visit) const {
    const std::vector<Vec3>& p = points_[mesh];
    const auto& corners = corners_[sides_[mesh]];
    const int greatest[2] = {width_ - 1, height_ - 1};
    for (std::uint32_t t = 0; t < corners.size(); ++t) {
        Span span;
        bool over = true;
        for (std::size_t k = 0; k < 2; ++k) {
            const auto [low, high] =
                std::minmax({p[corners[t][0]][k], p[corners[t][1]][k], p[corners[t][2]][k]});
            span.first[k] = std::max(0, column(low, static_cast<int>(k)));
            span.last[k] = std::min(greatest[k], column(high, static_cast<int>(k)));
            over = over && span.first[k] <= span.last[k];
        }
        if (over) visit(t, span);
    }
}

void SunView::fill(const std::vector<std::shared_ptr<const PatchMesh>>& meshes, int cells) {
    for (int side = 0; side < 2; ++side) corners_[side] = half_triangles(side, cells);
    sides_.resize(meshes.size());
    points_.resize(meshes.size());
    const std::size_t count = index(0, height_);
    std::vector<std::atomic<std::uint32_t>> next(count);
    const auto each = [&](const auto& visit) {
        tbb::parallel_for(std::size_t{0}, meshes.size(), [&](std::size_t m) {
            for_triangles(m, [&](std::uint32_t t, const Span& span) {
                for (int y = span.first[1]; y <= span.last[1]; ++y)
                    for (int x = span.first[0]; x <= span.last[0]; ++x) visit(m, t, next[index(x, y)]);
            });
        });
    };
    tbb::parallel_for(std::size_t{0}, meshes.size(), [&](std::size_t m) {
        sides_[m] = meshes[m]->half.side;
        points_[m].reserve(meshes[m]->vertices.size());
        for (const PatchVertex& v : meshes[m]->vertices)
            points_[m].push_back(frame_.across(frame_.from_eye(*meshes[m], v)));
    });
    each([](std::size_t, std::uint32_t, auto& n) { n.fetch_add(1, std::memory_order_relaxed); });
    begin_.assign(count + 1, 0);
    for (std::size_t k = 0; k < count; ++k) {
        begin_[k + 1] = begin_[k] + next[k].load(std::memory_order_relaxed);
        next[k].store(begin_[k], std::memory_order_relaxed);
    }
    references_.resize(begin_.back());
    each([&](std::size_t m, std::uint32_t t, auto& n) {
        references_[n.fetch_add(1, std::memory_order_relaxed)] = {static_cast<std::uint32_t>(m), t};
    });
}

bool SunView::hidden(const Vec3& p, double least) const {
    const int x = std::clamp(column(p[0], 0), 0, width_ - 1), y = std::clamp(column(p[1], 1), 0, height_ - 1);
    for (std::uint32_t k = begin_[index(x, y)], end = begin_[index(x, y) + 1]; k < end; ++k) {
        const Reference r = references_[k];
        const auto& corner = corners_[sides_[r.mesh]][r.triangle];
        const Vec3 &a = points_[r.mesh][corner[0]], &b = points_[r.mesh][corner[1]],
                   &c = points_[r.mesh][corner[2]];
        const double bx = b[0] - a[0], by = b[1] - a[1], cx = c[0] - a[0], cy = c[1] - a[1];
        const double area = bx * cy - cx * by, px = p[0] - a[0], py = p[1] - a[1];
        if (area == 0) continue;
        const double u = (px * cy - cx * py) / area, v = (bx * py - px * by) / area;
        if (u < 0 || v < 0 || u + v > 1) continue;
        if (a[2] + u * (b[2] - a[2]) + v * (c[2] - a[2]) - p[2] > least) return true;
    }
    return false;
}

}  // namespace carat
