// codec: heights of diamonds <-> bytes, and the repository file. Knows no sphere but the diamond DAG of
// globe/.
//
//   heights     int32 multiples of the quantum q (metres); |h| <= 2^30               heights.hpp
//   P, V, C     vertices of a diamond; once refined, the same and the cell centres   heights.hpp
//   prediction  C from vertices, inner V from centres: order 2, 4 or 6 by diamond,
//               one-sided at borders                                                 predict.hpp
//   quantiser   step 2r + 1 quanta: |error| <= r q + q/2 <= tolerance                quantize.hpp
//   modes       0 interpolating, 1 filtered (V first), 2 the C-BDAM paper's          diamond_codec.hpp
//   coder       range (default): static contexts, interleaved rANS; gamma:
//               zero-quadtree with Elias-gamma leaves, faster                        coding.hpp
//   summaries   min, max and delta (distance to S) of a half, rounded outwards       summary.hpp
//   file        header, roots, pages, two-level directory; law: docs/format.md       repository, writer
//   surface     heights and S anywhere, cached                                       surface.hpp
//   verify      everything a file claims, and its structure                          verify.hpp
//   colour      sRGB within a tolerance: three repositories in one file              colour.hpp
//
// Promise (numbers in docs/accuracy.md): every height of every level is within `tolerance` metres of that
// level's reference data, the rounding to the quantum included. Decoding is integer arithmetic alone (int64,
// results modulo 2^32): the same bits on every compiler, processor and thread count. All functions are
// thread-safe unless they say otherwise.
#pragma once

#include "carat/codec/coding.hpp"
#include "carat/codec/colour.hpp"
#include "carat/codec/diamond_codec.hpp"
#include "carat/codec/heights.hpp"
#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/codec/repository.hpp"
#include "carat/codec/summary.hpp"
#include "carat/codec/surface.hpp"
#include "carat/codec/verify.hpp"
#include "carat/codec/writer.hpp"
