// Coding the residuals of one diamond: random access, no state between diamonds.
//
//   mode 0  interpolating   V = P                                   C = pred(V) + step qC
//   mode 1  filtered        V = P + step qV                         C = pred(V) + step qC
//   mode 2  the paper's     C = pred(P) + step qC                   V = 2P - pred(C) + step qV
//
// Border vertices are kept in every mode (V = P), so neighbours agree without talking to each other and any
// mix of modes fits together. Mode 2 is update-first lifting with alpha = 1/2: analysis P = (V + pred(C))/2
// (C-BDAM 2006, eqs. 1-8; in eq. 8 with the *reconstructed* P, the only one a decoder has).
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "carat/codec/coding.hpp"
#include "carat/codec/heights.hpp"

namespace carat {

class GammaReader;
class GammaWriter;
struct RangeScratch;

enum class Mode : std::uint8_t { interpolating = 0, filtered = 1, paper = 2 };

// How a blob is coded; one byte of a page's index.
struct BlobInfo {
    Mode mode = Mode::interpolating;
    int leaf_size = 2;          // gamma coder: 2 or 4; range coder: 2
    bool gamma = false;         // coded by gamma though the file's coder is range
    Order order = Order::four;  // of every prediction of the diamond

    std::uint8_t to_byte() const;
    // Throws Error(corrupt) for a byte no writer makes.
    static BlobInfo from_byte(std::uint8_t byte);
    bool operator==(const BlobInfo&) const = default;
};

struct EncodedResiduals {
    BlobInfo info;
    std::vector<std::byte> blob;  // empty: all residuals are zero
};

// Work space of encoder and decoder, reused between calls; one per thread. After a first diamond of the same
// n and coding, and one as large, decoding allocates nothing and encoding only the blob that it returns.
struct CodecScratch {
    CodecScratch();
    ~CodecScratch();
    CodecScratch(CodecScratch&&) noexcept;
    CodecScratch& operator=(CodecScratch&&) noexcept;

    std::vector<std::int32_t> prediction, indices_c, indices_v, trial;
    std::unique_ptr<RangeScratch> range;
    std::unique_ptr<GammaReader> gamma;
    std::unique_ptr<GammaWriter> gamma_writer;
    RangeStatistics* statistics = nullptr;  // if set, the range encoder counts its tokens there
};

// Encodes a refinement: p (n x n, reconstructed), reference V and C. Writes what a decoder will reconstruct
// to `out`. Every value of out is within `radius` quanta of the reference, border V excepted, which are p's.
// Of the orders that `coding` allows the one with the shortest code is taken.
// n = 2^k + 1, 5 to 129; 0 <= radius <= 2^29; heights of p and reference within +-kGreatestHeight. Any other
// height is coded too, but out is then within the radius modulo 2^32 only. Sizes are asserted only: in a
// build without assertions wrong ones are undefined behaviour. `out` must be none of the inputs.
EncodedResiduals encode_residuals(const Coding& coding, Mode mode, std::span<const std::int32_t> p,
                                  const RefinedHeights& reference, std::int32_t radius, RefinedHeights& out,
                                  CodecScratch& scratch);

// Decodes; an empty blob means all residuals zero. Throws Error(corrupt|truncated) for bytes no encoder
// makes; `out` is then unspecified. The blob and the heights of p may be anything; n = 2^k + 1, 5 to 129,
// p.size() = n * n and 0 <= radius <= 2^29 are the caller's promise, asserted only: in a build without
// assertions anything else is undefined behaviour. p must not lie in `out`,
// but in mode 0 it may be out.v.
void decode_residuals(const Coding& coding, const BlobInfo& info, std::span<const std::byte> blob,
                      std::span<const std::int32_t> p, int n, std::int32_t radius, RefinedHeights& out,
                      CodecScratch& scratch);

// Analysis of mode 1 and 2, fine to coarse: the reference P of a diamond from its reference V and C.
// Interior: (V + pred(C)) / 2 rounded half up, held within +-kGreatestHeight; border: V. p.size() = n * n
// (asserted only), p apart from the reference. Allocates nothing.
void filter_vertices(const RefinedHeights& reference, std::span<std::int32_t> p);

}  // namespace carat
