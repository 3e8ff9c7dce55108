#include <zstd.h>

#include <cstring>

#include "carat/globe/error.hpp"
#include "tile_codec.hpp"

namespace carat::bench {
namespace {

constexpr int kLevel = 9;

void check(std::size_t code) {
    if (ZSTD_isError(code) != 0)
        throw Error(ErrorCode::corrupt, std::string("ZSTD: ") + ZSTD_getErrorName(code));
}

// Differences along rows in the narrowest unsigned type that holds the indices, as a TIFF with predictor 2.
template <class Word>
Bytes differences(const std::vector<std::uint32_t>& index, int width) {
    std::vector<Word> words(index.size());
    for (std::size_t k = 0; k < index.size(); ++k) {
        const std::uint32_t left = k % static_cast<std::size_t>(width) == 0 ? 0 : index[k - 1];
        words[k] = static_cast<Word>(index[k] - left);
    }
    Bytes out(words.size() * sizeof(Word));
    std::memcpy(out.data(), words.data(), out.size());
    return out;
}

template <class Word>
void sums(const Bytes& bytes, int width, std::vector<std::uint32_t>& index) {
    std::vector<Word> words(index.size());
    std::memcpy(words.data(), bytes.data(), bytes.size());
    for (std::size_t row = 0; row < words.size(); row += static_cast<std::size_t>(width)) {
        Word value = 0;
        for (std::size_t x = 0; x < static_cast<std::size_t>(width); ++x)
            index[row + x] = value = static_cast<Word>(value + words[row + x]);
    }
}

class PredictorZstd : public QuantisedCodec {
    void encode_indices(const Quantised& q, int width, int, Bytes& out) override {
        const bool wide = q.greatest > 0xFFFF;
        out.push_back(static_cast<std::byte>(wide));
        const Bytes coded = zstd_compress(wide ? differences<std::uint32_t>(q.index, width)
                                               : differences<std::uint16_t>(q.index, width));
        out.insert(out.end(), coded.begin(), coded.end());
    }
    void decode_indices(std::span<const std::byte> bytes, int width, int,
                        std::vector<std::uint32_t>& index) override {
        const bool wide = bytes[0] != std::byte{0};
        Bytes raw(index.size() * (wide ? 4 : 2));
        zstd_decompress(bytes.subspan(1), raw);
        if (wide)
            sums<std::uint32_t>(raw, width, index);
        else
            sums<std::uint16_t>(raw, width, index);
    }
};

}  // namespace

Bytes zstd_compress(std::span<const std::byte> in) {
    Bytes out(ZSTD_compressBound(in.size()));
    const std::size_t n = ZSTD_compress(out.data(), out.size(), in.data(), in.size(), kLevel);
    check(n);
    out.resize(n);
    return out;
}

void zstd_decompress(std::span<const std::byte> in, std::span<std::byte> out) {
    const std::size_t n = ZSTD_decompress(out.data(), out.size(), in.data(), in.size());
    check(n);
    if (n != out.size()) throw Error(ErrorCode::corrupt, "ZSTD: fewer bytes than expected");
}

std::unique_ptr<Contestant> make_predictor_zstd() { return std::make_unique<PredictorZstd>(); }

}  // namespace carat::bench
