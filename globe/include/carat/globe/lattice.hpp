// Lattice: the integer points on the surface of the cube [-2^30, 2^30]^3.
//
// A point is the same triple seen from any face, so edges and corners of the cube need no special names. A
// coordinate fits int32; a *difference* of coordinates does not, so vectors and all arithmetic are int64.
// Faces: 0 +x, 1 -x, 2 +y, 3 -y, 4 +z, 5 -z.
#pragma once

#include <array>
#include <compare>
#include <cstdint>

namespace carat {

inline constexpr int kLatticeBits = 30;
inline constexpr std::int64_t kLatticeExtent = std::int64_t{1} << kLatticeBits;
inline constexpr int kFaces = 6;

// A difference of lattice points, or a point in 64 bits.
struct LatticeVector {
    std::int64_t x = 0, y = 0, z = 0;

    constexpr std::int64_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
    constexpr std::int64_t& at(int axis) { return axis == 0 ? x : axis == 1 ? y : z; }
    friend constexpr bool operator==(const LatticeVector&, const LatticeVector&) = default;
};

constexpr LatticeVector operator+(const LatticeVector& a, const LatticeVector& b) {
    return {a.x + b.x, a.y + b.y, a.z + b.z};
}
constexpr LatticeVector operator-(const LatticeVector& a, const LatticeVector& b) {
    return {a.x - b.x, a.y - b.y, a.z - b.z};
}
constexpr LatticeVector operator*(std::int64_t k, const LatticeVector& a) {
    return {k * a.x, k * a.y, k * a.z};
}

// A point of the lattice. Ordered lexicographically (x, then y, then z).
struct LatticePoint {
    std::int32_t x = 0, y = 0, z = 0;

    constexpr std::int32_t operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
    friend constexpr auto operator<=>(const LatticePoint&, const LatticePoint&) = default;
};

constexpr LatticeVector wide(const LatticePoint& p) { return {p.x, p.y, p.z}; }
constexpr LatticePoint narrow(const LatticeVector& v) {
    return {static_cast<std::int32_t>(v.x), static_cast<std::int32_t>(v.y), static_cast<std::int32_t>(v.z)};
}

constexpr LatticeVector cross(const LatticeVector& a, const LatticeVector& b) {
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}
constexpr std::int64_t dot(const LatticeVector& a, const LatticeVector& b) {
    return a.x * b.x + a.y * b.y + a.z * b.z;
}

// The axis (0, 1, 2) a face is perpendicular to, and the sign of its outward normal.
constexpr int face_axis(int face) { return face >> 1; }
constexpr int face_sign(int face) { return (face & 1) != 0 ? -1 : 1; }
// The two in-face axes in ascending order.
constexpr int face_u_axis(int face) { return face_axis(face) == 0 ? 1 : 0; }
constexpr int face_v_axis(int face) { return face_axis(face) == 2 ? 1 : 2; }
constexpr LatticeVector axis_vector(int axis, std::int64_t length) {
    return {axis == 0 ? length : 0, axis == 1 ? length : 0, axis == 2 ? length : 0};
}
constexpr LatticeVector face_normal(int face) { return axis_vector(face_axis(face), face_sign(face)); }

constexpr bool on_face(const LatticePoint& p, int face) {
    return p[face_axis(face)] == face_sign(face) * kLatticeExtent;
}
// True if the triple lies on the surface of the cube.
bool on_lattice(const LatticeVector& v);
// The lowest-numbered face that contains the point. Precondition: on_lattice.
int face_of(const LatticePoint& p);

// Hash of a point, equal on every machine.
std::uint64_t hash_value(const LatticePoint& p);

struct LatticePointHash {
    std::size_t operator()(const LatticePoint& p) const { return static_cast<std::size_t>(hash_value(p)); }
};

}  // namespace carat
