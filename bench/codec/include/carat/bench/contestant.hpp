// Who takes part in the comparison: Carat's kernel on a planar lattice, and the codecs one would use instead.
//
//   carat-paper   mode 2, coder gamma: C-BDAM as printed        diamond
//   carat-gamma   mode 0, coder gamma                           diamond
//   lerc          LERC (Esri, GDAL), its own error bound        tile, whole
//   lerc+zstd     the same blobs through ZSTD 9                 tile, whole
//   zfp           ZFP, accuracy mode at the tolerance           4x4 block
//   zfp-tuned     ZFP, the widest doubled tolerance whose measured error keeps the bound
//   jxl-e3, -e7   JPEG XL lossless on quantised samples         tile, whole
//   jp2k          OpenJPEG, reversible 5/3, quantised samples   whole
//   pred2+zstd    horizontal differences (TIFF's predictor 2) of quantised samples, ZSTD 9    tile, whole
//
// All get the same bound. Integer samples and integer tolerance e: a quantiser step of 2e + 1 is legal (e =
// 0.5 means lossless), and what works on floats may be off by e + 0.49 before its result is rounded.
// Quantised float samples: step 2e less what rounding to float32 may add.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "carat/bench/raster.hpp"

namespace carat::bench {

// One codec at one tolerance. Keeps what it encoded until the next encode(). Single-threaded.
class Contestant {
  public:
    virtual ~Contestant() = default;
    // Not timed: tuning, allocation. Throws Error(unsupported) where the codec cannot take these samples.
    virtual void prepare(const std::vector<Raster>& tiles, double tolerance) = 0;
    // Returns the bytes of all tiles.
    virtual std::size_t encode(const std::vector<Raster>& tiles) = 0;
    // Into tiles of the right shapes.
    virtual void decode(std::vector<Raster>& tiles) = 0;
    // Shares of the decoding time: gathering from parents, kernel, storing leaves; empty: not known.
    virtual std::vector<double> decode_shares() const { return {}; }
};

struct ContestantInfo {
    std::string name;
    std::string unit;  // of random access when not cut into tiles
    bool tiled;        // also takes part on tiles
    std::unique_ptr<Contestant> (*make)();
};
const std::vector<ContestantInfo>& contestants();

}  // namespace carat::bench
