// A diamond worked out from the words of docs (centre and level given) and from nothing of globe's diamond
// code: vectors on the cube, no bit tricks, no parity of shifted coordinates beyond "the square that contains
// it".
#pragma once

#include <array>
#include <ostream>
#include <vector>

#include "carat/globe/diamond.hpp"
#include "random.hpp"

namespace carat {

inline void PrintTo(const LatticePoint& p, std::ostream* out) {
    *out << '(' << p.x << ", " << p.y << ", " << p.z << ')';
}
inline void PrintTo(const DiamondId& d, std::ostream* out) { *out << to_string(d); }
inline void PrintTo(const Half& h, std::ostream* out) { *out << to_string(h.diamond) << " half " << h.side; }

}  // namespace carat

namespace carat::test {

// Exact wide arithmetic: areas of the whole cube exceed 63 bits.
__extension__ using Int128 = __int128;

inline Int128 dot128(const LatticeVector& p, const LatticeVector& q) {
    return Int128{p.x} * q.x + Int128{p.y} * q.y + Int128{p.z} * q.z;
}

struct DesignDiamond {
    int level = 0;
    LatticeVector c, a, b;           // centre; (0,0) and (N-1,N-1)
    std::array<LatticeVector, 2> x;  // (N-1,0) and (0,N-1)
    std::array<int, 2> face{};       // of each half
    std::array<LatticeVector, 4> children;

    LatticePoint corner(int k) const { return narrow(k == 0 ? a : k == 1 ? b : x[k - 2]); }
};

inline std::vector<int> faces_of(const LatticeVector& p) {
    std::vector<int> faces;
    for (int f = 0; f < kFaces; ++f)
        if (on_face(narrow(p), f)) faces.push_back(f);
    return faces;
}

// Level 2k: a face-aligned square of half-size 2^(30-k).
inline DesignDiamond design_even(const LatticeVector& c, int level) {
    const std::int64_t s = kLatticeExtent >> (level / 2);
    const int face = faces_of(c).front();
    const int u = face_u_axis(face), v = face_v_axis(face);
    DesignDiamond d{level, c, {}, {}, {}, {face, face}, {}};
    const LatticeVector e1 = axis_vector(u, s), e2 = axis_vector(v, s);
    if (level == 0) {
        d.a = c - e1 - e2;  // lexicographically smallest of the four
        d.b = c + e1 + e2;
    } else {
        // The square two levels coarser that contains this one: its side is 4s.
        d.b = c;
        for (const int axis : {u, v})
            d.b.at(axis) = (c[axis] + kLatticeExtent) / (4 * s) * (4 * s) + 2 * s - kLatticeExtent;
        d.a = 2 * c - d.b;
    }
    LatticeVector p = d.a, q = d.a;
    p.at(u) = d.b[u];
    q.at(v) = d.b[v];
    const bool p_first = dot128(cross(p - d.a, d.b - p), face_normal(face)) > 0;
    d.x = p_first ? std::array{p, q} : std::array{q, p};
    d.children = {c + e1, c - e1, c + e2, c - e2};
    return d;
}

// Level 2k+1: centred on a side of two squares of half-size 2^(30-k).
inline DesignDiamond design_odd(const LatticeVector& m, int level) {
    const std::int64_t s = kLatticeExtent >> (level / 2);
    const std::vector<int> faces = faces_of(m);
    struct Inward {
        int face;
        LatticeVector direction;
    };
    std::vector<Inward> inward;
    LatticeVector t;
    if (faces.size() == 2) {
        t = axis_vector(3 - face_axis(faces[0]) - face_axis(faces[1]), 1);
        inward = {{faces[0], (-1) * face_normal(faces[1])}, {faces[1], (-1) * face_normal(faces[0])}};
    } else {
        // The squares' sides lie on lines whose shifted coordinate is a multiple of 2s; m is on one of them.
        const int u = face_u_axis(faces[0]), v = face_v_axis(faces[0]);
        const bool line_across_u = (m[u] + kLatticeExtent) % (2 * s) == 0;
        t = axis_vector(line_across_u ? v : u, 1);
        const LatticeVector d = axis_vector(line_across_u ? u : v, 1);
        inward = {{faces[0], d}, {faces[0], (-1) * d}};
    }
    const auto outwards = [&](const Inward& i) {
        return dot128(cross(i.direction, t), face_normal(i.face)) > 0;
    };
    if (!outwards(inward[0])) std::swap(inward[0], inward[1]);
    DesignDiamond d{level, m, m - s * t, m + s * t, {}, {inward[0].face, inward[1].face}, {}};
    for (std::size_t h = 0; h < 2; ++h) {
        d.x[h] = m + s * inward[h].direction;
        d.children[2 * h] = m - (s / 2) * t + (s / 2) * inward[h].direction;
        d.children[2 * h + 1] = m + (s / 2) * t + (s / 2) * inward[h].direction;
    }
    return d;
}

inline DesignDiamond design_diamond(const LatticePoint& centre, int level) {
    return level % 2 == 0 ? design_even(wide(centre), level) : design_odd(wide(centre), level);
}

// A diamond of the given level near a random place, often near or on a cube edge, a cube corner or a pole.
inline LatticePoint random_target(Random& random) {
    LatticeVector p;
    const int face = static_cast<int>(random.integer(0, kFaces - 1));
    for (int axis = 0; axis < 3; ++axis) {
        const std::int64_t special = kLatticeExtent * random.integer(-1, 1);
        p.at(axis) = random.chance(0.4) ? special : random.integer(-kLatticeExtent, kLatticeExtent);
    }
    p.at(face_axis(face)) = face_sign(face) * kLatticeExtent;
    return narrow(p);
}

inline DiamondId random_diamond(Random& random, int level) {
    const LatticePoint target = random_target(random);
    DiamondId d = root_diamond(faces_of(wide(target)).front());
    while (d.level() < level) {
        int best = 0;
        Int128 nearest = -1;
        for (int k = 0; k < 4; ++k) {
            const LatticeVector away = wide(corners(d).child_centre(k)) - wide(target);
            const Int128 distance = dot128(away, away);
            if (nearest < 0 || distance < nearest) {
                nearest = distance;
                best = k;
            }
        }
        d = child(d, random.chance(0.05) ? static_cast<int>(random.integer(0, 3)) : best);
    }
    return d;
}

}  // namespace carat::test
