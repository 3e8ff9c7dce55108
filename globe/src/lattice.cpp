#include "carat/globe/lattice.hpp"

#include <cassert>
#include <cstdlib>

namespace carat {

bool on_lattice(const LatticeVector& v) {
    bool on_a_face = false;
    for (int axis = 0; axis < 3; ++axis) {
        if (v[axis] < -kLatticeExtent || v[axis] > kLatticeExtent) return false;
        on_a_face |= v[axis] == kLatticeExtent || v[axis] == -kLatticeExtent;
    }
    return on_a_face;
}

int face_of(const LatticePoint& p) {
    for (int face = 0; face < kFaces; ++face)
        if (on_face(p, face)) return face;
    assert(false && "not a lattice point");
    return 0;
}

std::uint64_t hash_value(const LatticePoint& p) {
    // SplitMix64's finaliser over the packed triple; x and y fill 64 bits, z is folded in by the first round.
    std::uint64_t h =
        (static_cast<std::uint64_t>(static_cast<std::uint32_t>(p.x)) << 32) | static_cast<std::uint32_t>(p.y);
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9u;
    h += static_cast<std::uint32_t>(p.z) * std::uint64_t{0x9E3779B97F4A7C15u};
    h = (h ^ (h >> 27)) * 0x94D049BB133111EBu;
    return h ^ (h >> 31);
}

}  // namespace carat
