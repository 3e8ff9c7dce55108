// Small things that several of these tests need.
#pragma once

#include <cmath>

#include "carat/render/cut.hpp"
#include "render/cut/checks.hpp"
#include "render/cut/planets.hpp"
#include "render/cut/views.hpp"

namespace carat::test {

inline Vec3 minus(const Vec3& p, const Vec3& q) { return {p[0] - q[0], p[1] - q[1], p[2] - q[2]}; }
inline double norm(const Vec3& p) { return std::hypot(p[0], p[1], p[2]); }

inline Visibility visibility_of(const FakeRepository& repository, const View& view, double margin_pixels) {
    const RepositoryHeader& h = repository.header();
    return {view, repository.body(), h.min_height * h.quantum, h.max_height * h.quantum, margin_pixels};
}

inline Cut cut_of(const FakeRepository& repository, const View& view, double threshold) {
    return select_cut(repository, visibility_of(repository, view, threshold), threshold);
}

inline TrueSurface surface_of(const FakeRepository& repository) {
    return {repository.header(), repository.body(), [&repository](const Half& half, const LatticePoint& p) {
                return repository.surface_point(repository.leaf_at(half, p), p);
            }};
}

inline std::vector<const FakeRepository*> planets() {
    return {&rough_earth(), &plain_mars(), &smooth_ball()};
}

}  // namespace carat::test
