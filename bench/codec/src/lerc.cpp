#include <Lerc_c_api.h>

#include <algorithm>
#include <cstring>

#include "carat/globe/error.hpp"
#include "tile_codec.hpp"

namespace carat::bench {
namespace {

// Lerc's numbers of sample types.
constexpr unsigned kShort = 2, kFloat = 6;

void check(lerc_status status) {
    if (status != 0) throw Error(ErrorCode::corrupt, "LERC: status " + std::to_string(status));
}

const void* samples(const Raster& r) {
    return r.integer ? static_cast<const void*>(r.whole.data()) : r.real.data();
}
void* samples(Raster& r) { return r.integer ? static_cast<void*>(r.whole.data()) : r.real.data(); }

class Lerc : public TileCodec {
  public:
    explicit Lerc(bool zstd) : zstd_(zstd) {}

  protected:
    Bytes encode_tile(const Raster& t) override {
        const unsigned type = t.integer ? kShort : kFloat;
        room_.resize(std::max(room_.size(), t.bytes() * 2 + 4096));
        unsigned written = 0;
        check(lerc_encode(samples(t), type, 1, t.width, t.height, 1, 0, nullptr, safe_tolerance(),
                          reinterpret_cast<unsigned char*>(room_.data()), static_cast<unsigned>(room_.size()),
                          &written));
        const Bytes out(room_.begin(), room_.begin() + written);
        return zstd_ ? wrapped(out) : out;
    }

    void decode_tile(const Bytes& bytes, Raster& t) override {
        Bytes blob;
        if (zstd_) blob = unwrapped(bytes);
        const Bytes& lerc = zstd_ ? blob : bytes;
        check(lerc_decode(reinterpret_cast<const unsigned char*>(lerc.data()),
                          static_cast<unsigned>(lerc.size()), 0, nullptr, 1, t.width, t.height, 1,
                          t.integer ? kShort : kFloat, samples(t)));
    }

  private:
    static Bytes wrapped(const Bytes& blob) {
        const auto length = static_cast<std::uint32_t>(blob.size());
        Bytes out(sizeof length);
        std::memcpy(out.data(), &length, sizeof length);
        const Bytes coded = zstd_compress(blob);
        out.insert(out.end(), coded.begin(), coded.end());
        return out;
    }
    static Bytes unwrapped(const Bytes& bytes) {
        std::uint32_t length = 0;
        std::memcpy(&length, bytes.data(), sizeof length);
        Bytes out(length);
        zstd_decompress(std::span(bytes).subspan(sizeof length), out);
        return out;
    }

    bool zstd_;
    Bytes room_;  // kept between tiles
};

}  // namespace

std::unique_ptr<Contestant> make_lerc() { return std::make_unique<Lerc>(false); }
std::unique_ptr<Contestant> make_lerc_zstd() { return std::make_unique<Lerc>(true); }

}  // namespace carat::bench
