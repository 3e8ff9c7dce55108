#include "page_layout.hpp"

#include <algorithm>
#include <cassert>

namespace carat {
namespace {

constexpr int kBandShift = 57;

struct Square {
    int face;
    std::int64_t u, v;  // shifted coordinates of the low corner
    std::int64_t half;  // half-size
};

std::int64_t shifted(const LatticePoint& p, int axis) { return p[axis] + kLatticeExtent; }

LatticePoint at(int face, std::int64_t u, std::int64_t v) {
    LatticeVector p = face_sign(face) * axis_vector(face_axis(face), kLatticeExtent);
    p.at(face_u_axis(face)) = u - kLatticeExtent;
    p.at(face_v_axis(face)) = v - kLatticeExtent;
    return narrow(p);
}

Square square_of(DiamondId d) {
    const LatticePoint c = d.centre();
    const std::int64_t half = half_size(d.level());
    return {d.face(), shifted(c, face_u_axis(d.face())) - half, shifted(c, face_v_axis(d.face())) - half,
            half};
}

// Low corners of the squares of half-size h whose closure contains coordinate x.
std::array<std::int64_t, 2> low_corners(std::int64_t x, std::int64_t h) {
    const std::int64_t count = kLatticeExtent / h;
    const std::int64_t high = std::min(x / (2 * h), count - 1);
    const std::int64_t low = x % (2 * h) == 0 && x > 0 && x < 2 * kLatticeExtent ? x / (2 * h) - 1 : high;
    return {low * 2 * h, high * 2 * h};
}

DiamondId containing_square(DiamondId d, int level) {
    const LatticePoint c = d.centre();
    const std::int64_t h = half_size(level);
    DiamondId best;  // the greatest bits: any square is smaller
    for (int face = 0; face < kFaces; ++face) {
        if (!on_face(c, face)) continue;
        for (const std::int64_t u : low_corners(shifted(c, face_u_axis(face)), h))
            for (const std::int64_t v : low_corners(shifted(c, face_v_axis(face)), h))
                best = std::min(best, DiamondId::of_centre(at(face, u + h, v + h)));
    }
    return best;
}

int width(int j) { return 1 << (j / 2); }

int slot_in(const Square& page, int j, const LatticePoint& centre) {
    const int w = width(j);
    const std::int64_t h = page.half / w;  // half-size of the level's squares
    const std::int64_t u = shifted(centre, face_u_axis(page.face)) - page.u;
    const std::int64_t v = shifted(centre, face_v_axis(page.face)) - page.v;
    const auto x = static_cast<int>(u / (2 * h)), y = static_cast<int>(v / (2 * h));
    if (j % 2 == 0) return first_slot(j) + y * w + x;
    if (u % (2 * h) != 0) return first_slot(j) + y * w + x;  // along u: u is an odd multiple of h
    return first_slot(j) + w * (w + 1) + y * (w + 1) + x;
}

}  // namespace

int first_slot(int j) {
    static constexpr std::array<int, 7> kFirst{0, 1, 5, 9, 21, 37, 77};
    return kFirst[static_cast<std::size_t>(j)];
}

PageKey page_key(DiamondId square) {
    return (static_cast<PageKey>(square.level() / kBandLevels) << kBandShift) | square.bits();
}

std::optional<DiamondId> page_square(PageKey key) {
    const std::optional<DiamondId> d = DiamondId::parse(key & ((PageKey{1} << kBandShift) - 1));
    if (!d || d->level() % kBandLevels != 0 || page_key(*d) != key) return std::nullopt;
    return d;
}

std::optional<PageKey> parent_page(PageKey key) {
    const std::optional<DiamondId> d = page_square(key);
    assert(d);
    if (d->level() == 0) return std::nullopt;
    return page_key(containing_square(*d, d->level() - kBandLevels));
}

PageSlot page_slot(DiamondId d) {
    const int level = d.level();
    const DiamondId square = containing_square(d, level - level % kBandLevels);
    return {page_key(square), slot_in(square_of(square), level % kBandLevels, d.centre())};
}

DiamondId slot_diamond(DiamondId square, int slot) {
    assert(slot >= 0 && slot < kPageSlots);
    int j = 0;
    while (slot >= first_slot(j + 1)) ++j;
    const Square page = square_of(square);
    const int w = width(j);
    const std::int64_t h = page.half / w;
    int k = slot - first_slot(j);
    std::int64_t u = 0, v = 0;
    if (j % 2 == 0) {
        u = (2 * (k % w) + 1) * h;
        v = (2 * (k / w) + 1) * h;
    } else if (k < w * (w + 1)) {
        u = (2 * (k % w) + 1) * h;
        v = 2 * (k / w) * h;
    } else {
        k -= w * (w + 1);
        u = 2 * (k % (w + 1)) * h;
        v = (2 * (k / (w + 1)) + 1) * h;
    }
    return DiamondId::of_centre(at(page.face, page.u + u, page.v + v));
}

}  // namespace carat
