// Contestants that code one tile at a time, and the quantised samples that the lossless ones get.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "carat/bench/contestant.hpp"

namespace carat::bench {

using Bytes = std::vector<std::byte>;

class TileCodec : public Contestant {
  public:
    void prepare(const std::vector<Raster>& tiles, double tolerance) override;
    std::size_t encode(const std::vector<Raster>& tiles) override;
    void decode(std::vector<Raster>& tiles) override;

  protected:
    virtual Bytes encode_tile(const Raster& tile) = 0;
    virtual void decode_tile(const Bytes& bytes, Raster& tile) = 0;
    double tolerance() const { return tolerance_; }
    // What a codec may ask of its own arithmetic so that the result, rounded to float32, keeps the tolerance.
    double safe_tolerance() const { return safe_tolerance_; }

  private:
    double tolerance_ = 0, safe_tolerance_ = 0;
    std::vector<Bytes> coded_;
};

// Indices of the quantiser, offset so that the least is 0.
struct Quantised {
    std::int32_t least = 0;
    std::uint32_t greatest = 0;  // index
    std::vector<std::uint32_t> index;
};

// Lossless codecs on quantised samples: the blob begins with `least`, which is charged.
class QuantisedCodec : public TileCodec {
  public:
    void prepare(const std::vector<Raster>& tiles, double tolerance) override;

  protected:
    Bytes encode_tile(const Raster& tile) final;
    void decode_tile(const Bytes& bytes, Raster& tile) final;
    // Appends to `out`.
    virtual void encode_indices(const Quantised& q, int width, int height, Bytes& out) = 0;
    virtual void decode_indices(std::span<const std::byte> bytes, int width, int height,
                                std::vector<std::uint32_t>& index) = 0;

  private:
    Quantised quantise(const Raster& tile) const;
    double step_ = 1;
};

std::unique_ptr<Contestant> make_lerc();
std::unique_ptr<Contestant> make_lerc_zstd();
std::unique_ptr<Contestant> make_zfp();
std::unique_ptr<Contestant> make_zfp_tuned();
std::unique_ptr<Contestant> make_jxl_e3();
std::unique_ptr<Contestant> make_jxl_e7();
std::unique_ptr<Contestant> make_openjpeg();
std::unique_ptr<Contestant> make_predictor_zstd();

// ZSTD level 9, one thread.
Bytes zstd_compress(std::span<const std::byte> in);
void zstd_decompress(std::span<const std::byte> in, std::span<std::byte> out);

}  // namespace carat::bench
