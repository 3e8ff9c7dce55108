// Heights of one diamond, and how children take theirs from a refined parent.
//
// N = 65 by default; all matrices are row-major in (i, j): value (i, j) of an n x n matrix is at i * n + j.
// Heights are int32 multiples of the repository's quantum.
#pragma once

#include <cstdint>
#include <vector>

#include "carat/globe/diamond.hpp"

namespace carat {

inline constexpr std::int32_t kGreatestHeight = 1 << 30;  // |h| of every reference height, quanta

// P: the N x N vertex heights of a diamond. A diamond at the rim of the refined region has one half only;
// entries of an absent half are unspecified.
struct Heights {
    int n = 0;
    std::vector<std::int32_t> values;  // n * n
    std::array<bool, 2> has_half{false, false};

    std::int32_t at(int i, int j) const { return values[static_cast<std::size_t>(i * n + j)]; }
};

// V and C: heights of a diamond's vertices and cell centres after refinement.
struct RefinedHeights {
    int n = 0;
    std::vector<std::int32_t> v;  // n * n
    std::vector<std::int32_t> c;  // (n - 1) * (n - 1)
};

// Affine map from the index (i, j) of a child's half to *doubled* indices (p, q) of the parent's refined
// grid: p = p0 + i pi + j pj, q = q0 + i qi + j qj. p, q both even: vertex V(p/2, q/2); both odd: cell C(p/2,
// q/2).
struct ChildMap {
    int p0, q0, pi, qi, pj, qj;
};
ChildMap child_map(DiamondId parent, const Half& child_half, int cells);

// Half of an N x N matrix, its diagonal included: i >= j, i <= j, i + j <= N - 1, i + j >= N - 1.
enum class Triangle : std::uint8_t { left_lower, right_upper, left_upper, right_lower };

// Copies the child's half from its refined parent (vertices i >= j for side 0, i <= j for side 1) into out, N
// x N. The parent is carat::parent(child_half.diamond, child_half.side).
void gather_half(const RefinedHeights& parent, DiamondId parent_id, const Half& child_half,
                 std::int32_t* out);
// The same for rows and columns of one's own choice: `map` leads from them to the parent, and the half is
// `part`.
void gather_half(const RefinedHeights& parent, const ChildMap& map, Triangle part, std::int32_t* out);

}  // namespace carat
