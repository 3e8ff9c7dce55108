#include <zfp.h>

#include <algorithm>
#include <cmath>

#include "carat/globe/error.hpp"
#include "tile_codec.hpp"

namespace carat::bench {
namespace {

struct Close {
    void operator()(zfp_stream* s) const { zfp_stream_close(s); }
    void operator()(zfp_field* f) const { zfp_field_free(f); }
    void operator()(bitstream* b) const { stream_close(b); }
};

class Zfp : public TileCodec {
  public:
    explicit Zfp(bool tuned) : tuned_(tuned) {}

    void prepare(const std::vector<Raster>& tiles, double tolerance) override {
        TileCodec::prepare(tiles, tolerance);
        const bool integer = tiles[0].integer;
        // Integers may be off by the next half before they are rounded.
        accuracy_ = integer ? std::floor(tolerance) + 0.49 : tolerance;
        if (tuned_) tune(tiles, integer ? std::floor(tolerance) : tolerance);
    }

  protected:
    Bytes encode_tile(const Raster& t) override {
        std::vector<float> floats(t.real);
        if (t.integer) floats.assign(t.whole.begin(), t.whole.end());
        const std::unique_ptr<zfp_field, Close> field(field_of(floats, t));
        const std::unique_ptr<zfp_stream, Close> zfp(zfp_stream_open(nullptr));
        zfp_stream_set_accuracy(zfp.get(), accuracy_);
        Bytes out(zfp_stream_maximum_size(zfp.get(), field.get()));
        const std::unique_ptr<bitstream, Close> bits(stream_open(out.data(), out.size()));
        zfp_stream_set_bit_stream(zfp.get(), bits.get());
        const std::size_t n = zfp_compress(zfp.get(), field.get());
        if (n == 0) throw Error(ErrorCode::unsupported, "ZFP cannot encode");
        out.resize(n);
        return out;
    }

    void decode_tile(const Bytes& bytes, Raster& t) override {
        std::vector<float> floats(t.size());
        const std::unique_ptr<zfp_field, Close> field(field_of(floats, t));
        const std::unique_ptr<zfp_stream, Close> zfp(zfp_stream_open(nullptr));
        zfp_stream_set_accuracy(zfp.get(), accuracy_);
        const std::unique_ptr<bitstream, Close> bits(
            stream_open(const_cast<std::byte*>(bytes.data()), bytes.size()));
        zfp_stream_set_bit_stream(zfp.get(), bits.get());
        if (zfp_decompress(zfp.get(), field.get()) == 0) throw Error(ErrorCode::corrupt, "ZFP cannot decode");
        if (!t.integer) {
            t.real = std::move(floats);
            return;
        }
        std::transform(floats.begin(), floats.end(), t.whole.begin(),
                       [](float x) { return to_int16(static_cast<std::int32_t>(std::lrintf(x))); });
    }

  private:
    static zfp_field* field_of(std::vector<float>& floats, const Raster& t) {
        return zfp_field_2d(floats.data(), zfp_type_float, static_cast<std::size_t>(t.width),
                            static_cast<std::size_t>(t.height));
    }

    // ZFP keeps a power of two below the tolerance, and its bound is loose: double while the error allows.
    void tune(const std::vector<Raster>& tiles, double bound) {
        std::vector<Raster> out;
        for (const Raster& t : tiles) out.push_back(t.like());
        for (double good = accuracy_;; good *= 2) {
            accuracy_ = good * 2;
            encode(tiles);
            decode(out);
            for (std::size_t k = 0; k < tiles.size(); ++k)
                if (compare(tiles[k], out[k]).max > bound) {
                    accuracy_ = good;
                    return;
                }
            if (good > 1e6) return;
        }
    }

    bool tuned_;
    double accuracy_ = 0;
};

}  // namespace

std::unique_ptr<Contestant> make_zfp() { return std::make_unique<Zfp>(false); }
std::unique_ptr<Contestant> make_zfp_tuned() { return std::make_unique<Zfp>(true); }

}  // namespace carat::bench
