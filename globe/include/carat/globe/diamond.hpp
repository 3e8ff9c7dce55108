// Diamonds: identity, geometry and the DAG, by arithmetic on the lattice. No graph is stored.
//
// A diamond is known by its centre, which also fixes its level. Shifted in-face coordinates U, V in [0, 2^31]
// (coordinate + 2^30) of the centre; s = 2^t, t = the smaller count of trailing zeros of U and V; k = 30 - t:
//
//   U and V both odd multiples of s   level 2k, a square of half-size s
//   otherwise                         level 2k+1, half-diagonal s, centred on a side of two squares
//
//              x1 ---- b          a, b    ends of the longest edge: grid indices (0,0) and (N-1,N-1)
//             / \     /           x0, x1  right-angled corners: grid indices (N-1,0) and (0,N-1)
//            /   c   /            half 0  triangle a, x0, b: i >= j;   half 1  triangle a, b, x1: i <= j
//           /     \ /             i x j points outwards in both halves
//          a ---- x0              the halves share the diagonal a-b through the centre c
//
// Facts (tested exhaustively to level 9, at random to the deepest level):
//
//   parent of half h  the diamond centred at x_h; a level-0 corner is a cube corner, which centres no diamond
//   children          centred at the midpoints of a-x0, x0-b, a-x1, x1-b
//   child half        the half of a child whose right-angled corner is c; the two in half h tile half h
//   longest edge      of a half is the diagonal of one diamond; each leg is the longest edge of a child
//
// DiamondId: 64 bits,  0...0 | face (3) | Morton code of U/2^5 and V/2^5 (2 x 27 bits, U in the even bits).
// The face is the lowest-numbered one that contains the centre. Nearby diamonds have nearby ids.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <optional>
#include <string>

#include "carat/globe/lattice.hpp"

namespace carat {

// Deepest level whose vertices are lattice points, for N = 2^p + 1: 2(30 + 1 - p), 50 for N = 65.
constexpr int deepest_level(int p) { return 2 * (kLatticeBits + 1 - p); }
inline constexpr int kDeepestId = 50;  // deepest level a DiamondId can name

class DiamondId {
  public:
    constexpr DiamondId() = default;
    // Precondition: centre is the centre of a diamond of level <= 50 (see diamond_at for checked input).
    static DiamondId of_centre(const LatticePoint& centre);
    // Any 64 bits: nothing if they name no diamond.
    static std::optional<DiamondId> parse(std::uint64_t bits);

    constexpr std::uint64_t bits() const { return bits_; }
    LatticePoint centre() const;
    int face() const { return static_cast<int>(bits_ >> 54); }
    int level() const;

    friend constexpr auto operator<=>(const DiamondId&, const DiamondId&) = default;

  private:
    explicit constexpr DiamondId(std::uint64_t bits) : bits_(bits) {}
    std::uint64_t bits_ = ~std::uint64_t{0};  // default: names no diamond
};

struct DiamondIdHash {
    std::size_t operator()(DiamondId d) const {
        // Coarse ids end in zeros, so bits must come down before they go up.
        const std::uint64_t x = (d.bits() ^ (d.bits() >> 32)) * 0x9E3779B97F4A7C15u;
        return static_cast<std::size_t>(x ^ (x >> 32));
    }
};

// "level/face/U/V" for messages.
std::string to_string(DiamondId d);

// The diamond centred at a point of the lattice; nothing if there is none (cube corners, too deep).
std::optional<DiamondId> diamond_at(const LatticePoint& centre);

// The face diamond (level 0) of a face.
DiamondId root_diamond(int face);

struct DiamondCorners {
    LatticePoint a, b;              // ends of the longest edge
    std::array<LatticePoint, 2> x;  // right-angled corner of each half
    LatticePoint c;                 // centre
    int level = 0;

    // Midpoint of leg k of the halves: 0 a-x0, 1 x0-b, 2 a-x1, 3 x1-b.
    LatticePoint child_centre(int k) const;
};
DiamondCorners corners(DiamondId d);

// Half-size s (even levels) or half-diagonal s (odd levels) in lattice units: 2^(30 - level/2).
constexpr std::int64_t half_size(int level) { return kLatticeExtent >> (level / 2); }

// The parent on the side of half h: nothing for level 0.
std::optional<DiamondId> parent(DiamondId d, int half);
// Child k: 0, 1 in half 0 and 2, 3 in half 1. Precondition: level < 50.
DiamondId child(DiamondId d, int k);
std::array<DiamondId, 4> children(DiamondId d);
// Which half of `child` lies inside `parent`: its x equals the parent's centre. Precondition: parent of
// child.
int half_in_parent(DiamondId child, DiamondId parent);

// A half: a triangular patch.
struct Half {
    DiamondId diamond;
    int side = 0;  // 0: i >= j, 1: i <= j

    friend constexpr auto operator<=>(const Half&, const Half&) = default;
};
struct HalfHash {
    std::size_t operator()(const Half& h) const {
        return DiamondIdHash{}(h.diamond) * 2 + static_cast<std::size_t>(h.side);
    }
};
// The two halves that tile half h one level finer: across a-x and across x-b. Precondition: level < 50.
std::array<Half, 2> child_halves(const Half& h);
// The half one level coarser that contains h; nothing at level 0.
std::optional<Half> parent_half(const Half& h);
// The half of the same level across an edge: 0 the longest, 1 leg a-x, 2 leg x-b.
Half neighbour(const Half& h, int edge);

// Affine map of a half's index grid: vertex (i, j) lies at origin + i u + j v, 0 <= i, j <= cells, and i >= j
// for side 0, i <= j for side 1. cells = 2^p = N - 1. Precondition: level <= deepest_level(p).
struct HalfFrame {
    LatticeVector origin, u, v;

    LatticePoint vertex(std::int64_t i, std::int64_t j) const { return narrow(origin + i * u + j * v); }
};
HalfFrame half_frame(const Half& h, int cells);

}  // namespace carat
