// Which page a diamond lives in, and which slot of it: arithmetic, no tables.
//
// Band b holds levels 6b .. 6b+5. The page of a diamond is the even square of level 6b that contains its
// centre; on a tie (sides, cube edges) the one with the smallest DiamondId. A page has 77 slots: for j = 0..5
// the diamonds of level 6b + j centred in the closed square, 2^floor(j/2) =: w squares a side,
//   j even   w w squares                  slot = base + y w + x
//   j odd    (w+1) w sides along u        slot = base + y w + x,                     y = 0..w, x = 0..w-1
//            w (w+1) sides along v        slot = base + w (w+1) + y (w+1) + x,       y = 0..w-1, x = 0..w
// with x, y counted along the face's u and v axes (ascending axis order) from the square's low corner.
#pragma once

#include <cstdint>

#include "carat/globe/diamond.hpp"

namespace carat {

inline constexpr int kBandLevels = 6;
inline constexpr int kPageSlots = 77;

// Sorts bands first, then along the Morton curve.
using PageKey = std::uint64_t;  // band << 57 | DiamondId of the square

struct PageSlot {
    PageKey key = 0;
    int slot = 0;
};
PageSlot page_slot(DiamondId d);

PageKey page_key(DiamondId square);
// The square of a key; nothing if the key names none.
std::optional<DiamondId> page_square(PageKey key);
// The page one band coarser that contains a page's square; nothing for band 0.
std::optional<PageKey> parent_page(PageKey key);

// The diamond in a slot of a page, whether or not it is that page's own.
DiamondId slot_diamond(DiamondId square, int slot);
// First slot of level 6b + j, j = 0..6.
int first_slot(int j);

}  // namespace carat
