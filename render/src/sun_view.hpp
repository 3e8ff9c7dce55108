// Triangles in the sunlight over a rectangle across it, by cells, to be met by rays towards the sun.
#pragma once

#include <atomic>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "carat/render/patch_mesh.hpp"

namespace carat {

// Axes across the sunlight and towards the sun; coordinates in metres from the eye.
struct SunFrame {
    UnitVector eye{};
    double unit = 0;
    Vec3 right{}, up{}, sun{};  // orthonormal

    static SunFrame make(const UnitVector& eye, double unit, const Vec3& sun);
    Vec3 from_eye(const PatchMesh& mesh, const PatchVertex& vertex) const;
    Vec3 across(const Vec3& from_eye) const;
};

struct SunRectangle {
    double low[2] = {std::numeric_limits<double>::infinity(), std::numeric_limits<double>::infinity()};
    double high[2] = {-std::numeric_limits<double>::infinity(), -std::numeric_limits<double>::infinity()};

    void include(const Vec3& p);
    void grow(double margin);
    bool empty() const { return !(low[0] <= high[0]); }
    double side(int axis) const { return high[axis] - low[axis]; }
};

class SunView {
  public:
    SunView(const SunFrame& frame, const SunRectangle& where, double cell);

    double cell() const { return cell_; }
    // The camera far away towards the sun whose pixels are the cells; distance in metres.
    Camera camera(double distance) const;

    // Takes the triangles of all meshes. Uses the threads of the current TBB arena.
    void fill(const std::vector<std::shared_ptr<const PatchMesh>>& meshes, int cells);
    // Whether a triangle crosses the ray from p towards the sun further than `least` from p. p within the
    // rectangle.
    bool hidden(const Vec3& p, double least) const;

  private:
    struct Span {
        int first[2], last[2];
    };
    struct Reference {
        std::uint32_t mesh, triangle;
    };
    int column(double x, int axis) const;
    std::size_t index(int x, int y) const {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
    }
    template <class Visit>
    void for_triangles(std::size_t mesh, const Visit& visit) const;

    SunFrame frame_;
    double low_[2], cell_;
    int width_, height_;
    std::vector<int> sides_;                                // of the meshes
    std::vector<std::vector<Vec3>> points_;                 // of the meshes, across the sunlight
    std::vector<std::array<std::uint16_t, 3>> corners_[2];  // of the triangles of both sides
    std::vector<std::uint32_t> begin_;                      // by cell; one more
    std::vector<Reference> references_;
};

}  // namespace carat
