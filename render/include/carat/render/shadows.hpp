// Cast shadows of the relief: for every vertex of a draw list, whether the relief lets the sun see it.
//
// The sun looks at what is drawn: for each doubling of the distance from the eye, a view from far away
// towards the sun covers the vertices there with square cells as wide as a pixel at the near end (wider where
// that would be more than kShadowCells a side). Its own converged_cut(), true to kShadowError cells, holds
// whatever stands in the light of these vertices, on the screen or not, the body itself included. The ray
// from each vertex to the sun is met with the cut's triangles, in double precision: a vertex is lit unless
// one of them crosses its ray more than
//
//   kShadowError cells / cosine of the light with the normal
//
// above it. A vertex is a point of S (files of mode 0, in which samples keep their heights from level to
// level), and the cut lies within kShadowError cells of S: so smooth ground does not shade itself. The edge
// of a shadow is true to that error over the sine of the light's angle with the ground, and to the distance
// of two vertices (--spacing, unless the file has no nearer ones), between which the share is interpolated.
// The sun is a point: no penumbra. In files of modes 1 and 2 vertices of coarse levels lie off S, and ground
// may be spotted where that is more than the error.
#pragma once

#include "carat/render/draw_list.hpp"

namespace carat {

inline constexpr int kShadowCells = 3072;
inline constexpr double kShadowError = 0.5;

struct ShadowCounters {
    int views = 0;                // of the sun
    std::uint64_t triangles = 0;  // that may cast, in all of them
    double milliseconds = 0;
};

// Writes the sun's share, 0 or 255, into the highest byte of each mesh's colours (PatchMesh), making white
// ones where there are none. list: the converged cut of repository, view and detail. sun: towards it, unit,
// body frame. A vertex whose normal faces away from the sun is in shadow. Throws what converged_cut() throws.
// Uses the threads of the current TBB arena; the result does not depend on their number.
ShadowCounters cast_shadows(DrawList& list, const Repository& repository, const View& view, const Vec3& sun,
                            const Detail* detail = nullptr);

}  // namespace carat
