// render: from a repository and a camera to patches, and (render/vulkan) from patches to a picture. Depends
// on globe and codec's reader. This part needs no GPU; all but a Refiner is thread-safe and keeps no state.
//
//   frame      body-fixed as in globe/globe.hpp; bounds and views in metres, double
//   vertices   whole length units u = 2^(floor(log2 a) - 39) m, int64 a component      patch_mesh.hpp
//   position   of a vertex: one function of lattice point and height where shared      vertex_position.hpp
//   view       a camera and its frustum; heading clockwise from north, pitch up        view.hpp
//   visibility culling and screen error in pixels, both true bounds                    visibility.hpp
//   cut        the least within a threshold: a pure function of (file, view, threshold)  cut.hpp
//   heights    whole quanta, or 2^-25 of them below the leaves: always exact           half_heights.hpp
//   detail     relief synthesised below the leaves, the same from anywhere            detail.hpp
//   patches    exact positions, normals by finite differences, stitched along edges    patch_builder.hpp
//   draw list  all of the above in one call                                            draw_list.hpp
//   flight     where the eye is along keyframes                                        flight.hpp
//   paths      keyframes as JSON                                                       flight_path.hpp
//   shadows    which vertices the sun sees                                            shadows.hpp
//   refiner    the cut from frame to frame, against deadlines, with workers            refiner.hpp
//   sun        the subsolar point of the Earth and of Mars at a time                   sun.hpp
#pragma once

#include "carat/render/cut.hpp"
#include "carat/render/detail.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/flight.hpp"
#include "carat/render/flight_path.hpp"
#include "carat/render/octahedral.hpp"
#include "carat/render/patch_builder.hpp"
#include "carat/render/patch_mesh.hpp"
#include "carat/render/refiner.hpp"
#include "carat/render/shadows.hpp"
#include "carat/render/sun.hpp"
#include "carat/render/vertex_position.hpp"
#include "carat/render/view.hpp"
#include "carat/render/visibility.hpp"
