#include "carat/globe/diamond.hpp"

#include <algorithm>
#include <bit>
#include <cassert>

namespace carat {
namespace {

constexpr int kIdShift = 5;  // centres of level <= 50 are multiples of 2^5 in shifted coordinates
constexpr int kMortonBits = 27;

// Shifted in-face coordinates of a centre, and its level.
struct FaceCentre {
    int face = 0;
    std::int64_t u = 0, v = 0;

    bool odd_level() const { return std::countr_zero(bits(u)) != std::countr_zero(bits(v)); }
    int scale_bits() const { return std::min(std::countr_zero(bits(u)), std::countr_zero(bits(v))); }
    int level() const { return 2 * (kLatticeBits - scale_bits()) + (odd_level() ? 1 : 0); }
    std::int64_t half_size() const { return std::int64_t{1} << scale_bits(); }

  private:
    static std::uint64_t bits(std::int64_t x) { return static_cast<std::uint64_t>(x); }
};

FaceCentre face_centre(const LatticePoint& c) {
    const int face = face_of(c);
    return {face, c[face_u_axis(face)] + kLatticeExtent, c[face_v_axis(face)] + kLatticeExtent};
}

// True if some diamond of level <= kDeepestId is centred there.
bool is_centre(const FaceCentre& f) {
    const auto at_border = [](std::int64_t x) { return x == 0 || x == 2 * kLatticeExtent; };
    if (at_border(f.u) && at_border(f.v)) return false;  // cube corner
    return f.level() <= kDeepestId;
}

std::uint64_t spread(std::uint64_t x) {  // 27 bits to the even positions
    x = (x | (x << 16)) & 0x0000FFFF0000FFFFu;
    x = (x | (x << 8)) & 0x00FF00FF00FF00FFu;
    x = (x | (x << 4)) & 0x0F0F0F0F0F0F0F0Fu;
    x = (x | (x << 2)) & 0x3333333333333333u;
    return (x | (x << 1)) & 0x5555555555555555u;
}

std::uint64_t compact(std::uint64_t x) {
    x &= 0x5555555555555555u;
    x = (x | (x >> 1)) & 0x3333333333333333u;
    x = (x | (x >> 2)) & 0x0F0F0F0F0F0F0F0Fu;
    x = (x | (x >> 4)) & 0x00FF00FF00FF00FFu;
    x = (x | (x >> 8)) & 0x0000FFFF0000FFFFu;
    return (x | (x >> 16)) & 0xFFFFFFFFu;
}

LatticePoint unshift(int face, std::int64_t u, std::int64_t v) {
    LatticeVector p = face_sign(face) * axis_vector(face_axis(face), kLatticeExtent);
    p.at(face_u_axis(face)) = u - kLatticeExtent;
    p.at(face_v_axis(face)) = v - kLatticeExtent;
    return narrow(p);
}

FaceCentre decode(std::uint64_t bits) {
    const std::uint64_t morton = bits & ((std::uint64_t{1} << (2 * kMortonBits)) - 1);
    return {static_cast<int>(bits >> (2 * kMortonBits)),
            static_cast<std::int64_t>(compact(morton)) << kIdShift,
            static_cast<std::int64_t>(compact(morton >> 1)) << kIdShift};
}

LatticePoint midpoint(const LatticePoint& p, const LatticePoint& q) {
    const LatticeVector sum = wide(p) + wide(q);
    return narrow({sum.x / 2, sum.y / 2, sum.z / 2});  // always even here: exact
}

// Orders the right-angled corners so that (x0 - a) x (b - x0) points outwards on the half's own face.
void orient(DiamondCorners& d, const LatticePoint& p, const LatticePoint& q, int face_of_p) {
    const LatticeVector outward = cross(wide(p) - wide(d.a), wide(d.b) - wide(p));
    const bool p_first = outward[face_axis(face_of_p)] * face_sign(face_of_p) > 0;
    d.x = p_first ? std::array{p, q} : std::array{q, p};
}

void even_corners(DiamondCorners& d, const FaceCentre& f) {
    const std::int64_t s = f.half_size();
    const LatticeVector c = wide(d.c);
    const LatticeVector e1 = axis_vector(face_u_axis(f.face), s), e2 = axis_vector(face_v_axis(f.face), s);
    std::int64_t su = 1, sv = 1;  // from c towards b
    if (d.level == 0) {
        // (0,0) is the lexicographically smallest corner: both in-face coordinates low.
        d.a = narrow(c - e1 - e2);
        d.b = narrow(c + e1 + e2);
    } else {
        // b is the centre of the square two levels coarser: both coordinates odd multiples of 2s.
        su = ((f.u + s) / (2 * s)) % 2 != 0 ? 1 : -1;
        sv = ((f.v + s) / (2 * s)) % 2 != 0 ? 1 : -1;
        d.b = narrow(c + su * e1 + sv * e2);
        d.a = narrow(c - su * e1 - sv * e2);
    }
    orient(d, narrow(c + su * e1 - sv * e2), narrow(c - su * e1 + sv * e2), f.face);
}

void odd_corners(DiamondCorners& d, const FaceCentre& f) {
    const std::int64_t s = f.half_size();
    const bool along_u = (f.u / s) % 2 != 0;  // the side runs along the axis of the odd multiple
    const int t_axis = along_u ? face_u_axis(f.face) : face_v_axis(f.face);
    const int d_axis = along_u ? face_v_axis(f.face) : face_u_axis(f.face);
    const LatticeVector c = wide(d.c), t = axis_vector(t_axis, s);
    d.a = narrow(c - t);
    d.b = narrow(c + t);
    const LatticeVector inward = axis_vector(d_axis, s);
    const std::int64_t across = along_u ? f.v : f.u;
    if (across != 0 && across != 2 * kLatticeExtent) {
        orient(d, narrow(c + inward), narrow(c - inward), f.face);
        return;
    }
    // On a cube edge one corner lies in this face, the other in the face beyond, straight down from the edge.
    const std::int64_t sign = across == 0 ? 1 : -1;
    const LatticePoint here = narrow(c + sign * inward);
    const LatticePoint beyond = narrow(c - s * face_normal(f.face));
    orient(d, here, beyond, f.face);
}

DiamondCorners corners_of(const FaceCentre& f) {
    DiamondCorners d;
    d.c = unshift(f.face, f.u, f.v);
    d.level = f.level();
    if (f.odd_level())
        odd_corners(d, f);
    else
        even_corners(d, f);
    return d;
}

// The half of a diamond that has a child centred at the point.
int side_of_child(const DiamondCorners& d, const LatticePoint& centre) {
    return d.child_centre(0) == centre || d.child_centre(1) == centre ? 0 : 1;
}

}  // namespace

DiamondId DiamondId::of_centre(const LatticePoint& centre) {
    const FaceCentre f = face_centre(centre);
    assert(is_centre(f));
    return DiamondId((static_cast<std::uint64_t>(f.face) << (2 * kMortonBits)) |
                     spread(static_cast<std::uint64_t>(f.u >> kIdShift)) |
                     (spread(static_cast<std::uint64_t>(f.v >> kIdShift)) << 1));
}

std::optional<DiamondId> DiamondId::parse(std::uint64_t bits) {
    if ((bits >> (2 * kMortonBits)) >= kFaces) return std::nullopt;
    const FaceCentre f = decode(bits);
    if (f.u > 2 * kLatticeExtent || f.v > 2 * kLatticeExtent) return std::nullopt;
    if (face_of(unshift(f.face, f.u, f.v)) != f.face || !is_centre(f)) return std::nullopt;
    return DiamondId(bits);
}

LatticePoint DiamondId::centre() const {
    const FaceCentre f = decode(bits_);
    return unshift(f.face, f.u, f.v);
}

int DiamondId::level() const { return decode(bits_).level(); }

std::string to_string(DiamondId d) {
    const FaceCentre f = decode(d.bits());
    return std::to_string(f.level()) + "/" + std::to_string(f.face) + "/" + std::to_string(f.u) + "/" +
           std::to_string(f.v);
}

std::optional<DiamondId> diamond_at(const LatticePoint& centre) {
    if (!on_lattice(wide(centre)) || !is_centre(face_centre(centre))) return std::nullopt;
    return DiamondId::of_centre(centre);
}

DiamondId root_diamond(int face) {
    return DiamondId::of_centre(unshift(face, kLatticeExtent, kLatticeExtent));
}

LatticePoint DiamondCorners::child_centre(int k) const {
    assert(k >= 0 && k < 4);
    return midpoint((k & 1) == 0 ? a : b, x[static_cast<std::size_t>(k >> 1)]);
}

DiamondCorners corners(DiamondId id) { return corners_of(decode(id.bits())); }

std::optional<DiamondId> parent(DiamondId d, int half) {
    const DiamondCorners k = corners(d);
    if (k.level == 0) return std::nullopt;
    return DiamondId::of_centre(k.x[static_cast<std::size_t>(half)]);
}

DiamondId child(DiamondId d, int k) { return DiamondId::of_centre(corners(d).child_centre(k)); }

std::array<DiamondId, 4> children(DiamondId d) {
    const DiamondCorners c = corners(d);
    return {DiamondId::of_centre(c.child_centre(0)), DiamondId::of_centre(c.child_centre(1)),
            DiamondId::of_centre(c.child_centre(2)), DiamondId::of_centre(c.child_centre(3))};
}

int half_in_parent(DiamondId child, DiamondId parent) {
    const DiamondCorners k = corners(child);
    const LatticePoint c = parent.centre();
    assert(k.x[0] == c || k.x[1] == c);
    return k.x[0] == c ? 0 : 1;
}

std::array<Half, 2> child_halves(const Half& h) {
    const DiamondCorners c = corners(h.diamond);
    std::array<Half, 2> out;
    for (int leg = 0; leg < 2; ++leg) {
        const DiamondId k = DiamondId::of_centre(c.child_centre(2 * h.side + leg));
        out[static_cast<std::size_t>(leg)] = {k, half_in_parent(k, h.diamond)};
    }
    return out;
}

std::optional<Half> parent_half(const Half& h) {
    const std::optional<DiamondId> p = parent(h.diamond, h.side);
    if (!p) return std::nullopt;
    return Half{*p, side_of_child(corners(*p), h.diamond.centre())};
}

Half neighbour(const Half& h, int edge) {
    if (edge == 0) return {h.diamond, 1 - h.side};
    // A leg is the longest edge of a child, and the child's other parent lies across it. The child may be one
    // level deeper than an id can name.
    const LatticePoint middle = corners(h.diamond).child_centre(2 * h.side + (edge - 1));
    const DiamondCorners child = corners_of(face_centre(middle));
    const DiamondId other = DiamondId::of_centre(child.x[child.x[0] == h.diamond.centre() ? 1 : 0]);
    return {other, side_of_child(corners(other), middle)};
}

HalfFrame half_frame(const Half& h, int cells) {
    const DiamondCorners c = corners(h.diamond);
    const LatticeVector a = wide(c.a), b = wide(c.b), x = wide(c.x[static_cast<std::size_t>(h.side)]);
    const auto step = [cells](const LatticeVector& d) {
        return LatticeVector{d.x / cells, d.y / cells, d.z / cells};  // exact: cells divides the half-size
    };
    return h.side == 0 ? HalfFrame{a, step(x - a), step(b - x)} : HalfFrame{a, step(b - x), step(x - a)};
}

}  // namespace carat
