#include <openjpeg.h>

#include <algorithm>
#include <bit>
#include <cstring>

#include "carat/globe/error.hpp"
#include "tile_codec.hpp"

namespace carat::bench {
namespace {

void check(bool good, const char* what) {
    if (!good) throw Error(ErrorCode::corrupt, std::string("OpenJPEG: ") + what);
}

// A stream over memory, for writing (grows) or reading.
struct Memory {
    Bytes bytes;
    std::size_t at = 0;
};

OPJ_SIZE_T read_some(void* buffer, OPJ_SIZE_T n, void* user) {
    auto& m = *static_cast<Memory*>(user);
    const std::size_t count = std::min(n, m.bytes.size() - m.at);
    if (count == 0) return static_cast<OPJ_SIZE_T>(-1);
    std::memcpy(buffer, m.bytes.data() + m.at, count);
    m.at += count;
    return count;
}

OPJ_SIZE_T write_some(void* buffer, OPJ_SIZE_T n, void* user) {
    auto& m = *static_cast<Memory*>(user);
    m.bytes.resize(std::max(m.bytes.size(), m.at + n));
    std::memcpy(m.bytes.data() + m.at, buffer, n);
    m.at += n;
    return n;
}

OPJ_OFF_T skip_some(OPJ_OFF_T n, void* user) {
    static_cast<Memory*>(user)->at += static_cast<std::size_t>(n);
    return n;
}

OPJ_BOOL seek_to(OPJ_OFF_T at, void* user) {
    static_cast<Memory*>(user)->at = static_cast<std::size_t>(at);
    return OPJ_TRUE;
}

struct Destroy {
    void operator()(opj_codec_t* codec) const { opj_destroy_codec(codec); }
    void operator()(opj_image_t* image) const { opj_image_destroy(image); }
};
struct DestroyStream {
    void operator()(opj_stream_t* stream) const { opj_stream_destroy(stream); }
};
using Codec = std::unique_ptr<opj_codec_t, Destroy>;
using Image = std::unique_ptr<opj_image_t, Destroy>;
using Stream = std::unique_ptr<opj_stream_t, DestroyStream>;

Stream stream_over(Memory& m, bool reading) {
    Stream s(opj_stream_default_create(reading ? OPJ_TRUE : OPJ_FALSE));
    opj_stream_set_user_data(s.get(), &m, nullptr);
    opj_stream_set_user_data_length(s.get(), m.bytes.size());
    opj_stream_set_read_function(s.get(), read_some);
    opj_stream_set_write_function(s.get(), write_some);
    opj_stream_set_skip_function(s.get(), skip_some);
    opj_stream_set_seek_function(s.get(), seek_to);
    return s;
}

class OpenJpeg : public QuantisedCodec {
    void encode_indices(const Quantised& q, int width, int height, Bytes& out) override {
        opj_image_cmptparm_t component{};
        component.dx = component.dy = 1;
        component.w = static_cast<OPJ_UINT32>(width);
        component.h = static_cast<OPJ_UINT32>(height);
        component.prec = static_cast<OPJ_UINT32>(std::max(1, static_cast<int>(std::bit_width(q.greatest))));
        const Image image(opj_image_create(1, &component, OPJ_CLRSPC_GRAY));
        check(image != nullptr, "no image");
        image->x1 = component.w;
        image->y1 = component.h;
        std::copy(q.index.begin(), q.index.end(), image->comps[0].data);
        opj_cparameters_t parameters;
        opj_set_default_encoder_parameters(&parameters);
        parameters.tcp_numlayers = 1;
        parameters.cp_disto_alloc = 1;  // with rate 0: lossless
        parameters.tcp_rates[0] = 0;
        while (parameters.numresolution > 1 &&
               (std::min(width, height) >> (parameters.numresolution - 1)) == 0)
            --parameters.numresolution;
        const Codec codec(opj_create_compress(OPJ_CODEC_J2K));
        check(opj_setup_encoder(codec.get(), &parameters, image.get()) != 0, "set up");
        Memory memory;
        {
            const Stream stream = stream_over(memory, false);
            check(opj_start_compress(codec.get(), image.get(), stream.get()) != 0 &&
                      opj_encode(codec.get(), stream.get()) != 0 &&
                      opj_end_compress(codec.get(), stream.get()) != 0,
                  "encoding");
        }
        out.insert(out.end(), memory.bytes.begin(), memory.bytes.end());
    }

    void decode_indices(std::span<const std::byte> bytes, int, int,
                        std::vector<std::uint32_t>& index) override {
        Memory memory{{bytes.begin(), bytes.end()}};
        const Stream stream = stream_over(memory, true);
        const Codec codec(opj_create_decompress(OPJ_CODEC_J2K));
        opj_dparameters_t parameters;
        opj_set_default_decoder_parameters(&parameters);
        check(opj_setup_decoder(codec.get(), &parameters) != 0, "set up");
        opj_image_t* raw = nullptr;
        check(opj_read_header(stream.get(), codec.get(), &raw) != 0, "header");
        const Image image(raw);
        check(opj_decode(codec.get(), stream.get(), image.get()) != 0, "decoding");
        std::copy_n(image->comps[0].data, index.size(), index.begin());
    }
};

}  // namespace

std::unique_ptr<Contestant> make_openjpeg() { return std::make_unique<OpenJpeg>(); }

}  // namespace carat::bench
