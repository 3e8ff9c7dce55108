#include "tile_codec.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "carat/globe/error.hpp"

namespace carat::bench {

void TileCodec::prepare(const std::vector<Raster>& tiles, double tolerance) {
    tolerance_ = tolerance;
    double greatest = 0;
    for (const Raster& t : tiles)
        for (const float x : t.real) greatest = std::max(greatest, std::abs(static_cast<double>(x)));
    // Half a unit in the last place of at most |x| + tolerance, twice: samples and results are float32.
    safe_tolerance_ = tiles.at(0).integer ? tolerance : tolerance - std::ldexp(greatest + tolerance, -23);
    if (!(safe_tolerance_ > 0))
        throw Error(ErrorCode::unsupported, "the tolerance is below the precision of float32");
}

std::size_t TileCodec::encode(const std::vector<Raster>& tiles) {
    coded_.resize(tiles.size());
    std::size_t bytes = 0;
    for (std::size_t k = 0; k < tiles.size(); ++k) {
        coded_[k] = encode_tile(tiles[k]);
        bytes += coded_[k].size();
    }
    return bytes;
}

void TileCodec::decode(std::vector<Raster>& tiles) {
    for (std::size_t k = 0; k < tiles.size(); ++k) decode_tile(coded_[k], tiles[k]);
}

void QuantisedCodec::prepare(const std::vector<Raster>& tiles, double tolerance) {
    TileCodec::prepare(tiles, tolerance);
    step_ = tiles.at(0).integer ? 2 * std::floor(tolerance) + 1 : 2 * safe_tolerance();
}

Quantised QuantisedCodec::quantise(const Raster& tile) const {
    std::vector<std::int32_t> k(tile.size());
    if (tile.integer) {
        const auto step = static_cast<std::int32_t>(step_), shift = step / 2 + step * (40000 / step + 1);
        const std::int32_t back = shift / step;
        std::transform(tile.whole.begin(), tile.whole.end(), k.begin(),
                       [&](std::int16_t x) { return (x + shift) / step - back; });
    } else {
        constexpr double kGreatest = 1 << 30;  // differences of two must fit
        std::transform(tile.real.begin(), tile.real.end(), k.begin(), [&](float x) {
            const double index = std::rint(static_cast<double>(x) / step_);
            if (!(std::abs(index) <= kGreatest))
                throw Error(ErrorCode::limit, "heights that large do not fit at this tolerance");
            return static_cast<std::int32_t>(index);
        });
    }
    const auto [least, greatest] = std::minmax_element(k.begin(), k.end());
    Quantised q;
    q.least = *least;
    q.greatest = static_cast<std::uint32_t>(*greatest - *least);
    q.index.resize(k.size());
    std::transform(k.begin(), k.end(), q.index.begin(),
                   [&](std::int32_t x) { return static_cast<std::uint32_t>(x - q.least); });
    return q;
}

Bytes QuantisedCodec::encode_tile(const Raster& tile) {
    const Quantised q = quantise(tile);
    Bytes out(sizeof q.least);
    std::memcpy(out.data(), &q.least, sizeof q.least);
    encode_indices(q, tile.width, tile.height, out);
    return out;
}

void QuantisedCodec::decode_tile(const Bytes& bytes, Raster& tile) {
    std::int32_t least = 0;
    std::memcpy(&least, bytes.data(), sizeof least);
    std::vector<std::uint32_t> index(tile.size());
    decode_indices(std::span(bytes).subspan(sizeof least), tile.width, tile.height, index);
    if (tile.integer) {
        const auto step = static_cast<std::int32_t>(step_);
        std::transform(index.begin(), index.end(), tile.whole.begin(), [&](std::uint32_t i) {
            return to_int16((static_cast<std::int32_t>(i) + least) * step);
        });
    } else {
        std::transform(index.begin(), index.end(), tile.real.begin(), [&](std::uint32_t i) {
            return static_cast<float>((static_cast<std::int64_t>(i) + least) * step_);
        });
    }
}

}  // namespace carat::bench
