// What the refinement hands to whoever draws: fixed-size patches with exact positions, and a camera.
//
// One length unit a file: u = 2^(floor(log2 a) - 39) metres, 2^-17 m (7.6 micrometres) on Earth. A vertex is
// round(position / u), int64 a component; so a vertex shared by patches is the same three integers, and
// (anchor + offset - eye) is exact wherever it is computed.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <vector>

#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"
#include "carat/globe/sphere.hpp"
#include "carat/render/block_allocator.hpp"

namespace carat {

using UnitVector = std::array<std::int64_t, 3>;  // a point or offset in length units, body frame

// The length unit u of a body, metres: a power of two.
double length_unit(const Ellipsoid& body);
// round(position / unit), halves away from zero. position in metres, |position| < 2^62 units.
UnitVector to_units(const Vec3& position, double unit);
// Metres, exact while |p| < 2^53 units.
Vec3 to_metres(const UnitVector& p, double unit);

// One vertex of a patch as the GPU reads it: 32 bytes, std430.
struct PatchVertex {
    UnitVector offset;                   // from the patch's anchor, length units
    std::array<std::int16_t, 2> normal;  // octahedral, snorm16, body frame, outwards
    float height;                        // metres above the datum surface
};
static_assert(sizeof(PatchVertex) == 32);

// A half with its vertices in the order of half_vertex_index (globe/patch.hpp). Immutable once built.
struct PatchMesh {
    Half half;
    UnitVector anchor{};                                             // length units: the right-angled corner
    std::vector<PatchVertex, BlockAllocator<PatchVertex>> vertices;  // half_vertex_count(cells)
    // Of each vertex, sRGB, red in the lowest byte; in the highest the sun's share once shadows are cast
    // (shadows.hpp). Empty: none.
    std::vector<std::uint32_t> colours = {};
};

// A perspective camera. Axes are orthonormal in the body frame; pixel (0,0) is the top left corner.
struct Camera {
    UnitVector eye{};               // length units
    Vec3 right{}, up{}, forward{};  // unit
    double vertical_fov = 0;        // radians
    int width = 0, height = 0;      // pixels

    // Pixels per radian at the image centre: f = height / (2 tan(fov/2)).
    double focal_pixels() const;
    // Through a point of the picture, pixels; pixel centres are at + 0.5. Not unit: one along forward.
    Vec3 ray(double x, double y) const;
};

}  // namespace carat
