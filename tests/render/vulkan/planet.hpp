// Small planets as patch lists, and cameras and rays to look at them with: made from globe alone.
#pragma once

#include <gtest/gtest.h>

#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <vector>

#include "carat/vulkan/renderer.hpp"

namespace carat::test {

using Patches = std::vector<std::shared_ptr<const PatchMesh>>;
using HeightFunction = std::function<double(const Vec3& normal)>;  // metres

double dot(const Vec3& a, const Vec3& b);
Vec3 cross(const Vec3& a, const Vec3& b);
Vec3 scaled(double k, const Vec3& v);
Vec3 sum(const Vec3& a, const Vec3& b);
Vec3 unit(const Vec3& v);

// The mesh of a half over a body with the given heights; normals by central differences of the surface.
std::shared_ptr<const PatchMesh> make_mesh(const Ellipsoid& body, const Half& half, int cells,
                                           const HeightFunction& height);
Patches make_meshes(const Ellipsoid& body, const std::vector<Half>& halves, int cells,
                    const HeightFunction& height);

// All halves of a level.
std::vector<Half> level_halves(int level);
// The frontier of a random conforming cut: `picks` diamonds of the level refined with all their ancestors.
std::vector<Half> random_cut(int level, int picks, std::mt19937& random);

// Looks from `distance` metres from the centre, above a place, towards the centre turned by the tilt
// (degrees, towards up) and rolled (degrees).
Camera look_down(const Ellipsoid& body, Geodetic above, double distance, int width, int height,
                 double fov_degrees, double tilt = 0, double roll = 0);
Vec3 eye_metres(const Ellipsoid& body, const Camera& camera);

// Direction of the ray through a point of the picture; pixel centres are at + 0.5. Not normalised: one along
// forward.
Vec3 ray(const Camera& camera, double x, double y);
// Where a point relative to the eye is seen.
std::array<double, 2> project(const Camera& camera, const Vec3& relative);
// Distance to the nearest hit with the ellipsoid of the body grown by h metres on both axes, in units of the
// ray.
std::optional<double> hit(const Ellipsoid& body, double h, const Vec3& eye, const Vec3& direction);

// A renderer with validation, which must have said nothing when the test ends.
class RendererTest : public ::testing::Test {
  protected:
    Renderer& renderer(const Ellipsoid& body, int cells, int capacity = 4096);
    void TearDown() override;

  private:
    std::deque<Renderer> renderers_;  // references stay good
};

}  // namespace carat::test
