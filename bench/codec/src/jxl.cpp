#include <jxl/decode.h>
#include <jxl/encode.h>

#include <algorithm>

#include "carat/globe/error.hpp"
#include "tile_codec.hpp"

namespace carat::bench {
namespace {

constexpr JxlPixelFormat kFormat{1, JXL_TYPE_UINT16, JXL_LITTLE_ENDIAN, 0};

struct Destroy {
    void operator()(JxlEncoder* e) const { JxlEncoderDestroy(e); }
    void operator()(JxlDecoder* d) const { JxlDecoderDestroy(d); }
};

void check(bool good, const char* what) {
    if (!good) throw Error(ErrorCode::corrupt, std::string("JPEG XL: ") + what);
}

class JpegXl : public QuantisedCodec {
  public:
    explicit JpegXl(int effort) : effort_(effort) {}

  private:
    void encode_indices(const Quantised& q, int width, int height, Bytes& out) override {
        if (q.greatest > 0xFFFF) throw Error(ErrorCode::unsupported, "more than 2^16 quantiser indices");
        const std::vector<std::uint16_t> pixels(q.index.begin(), q.index.end());
        const std::unique_ptr<JxlEncoder, Destroy> encoder(JxlEncoderCreate(nullptr));
        JxlBasicInfo info;
        JxlEncoderInitBasicInfo(&info);
        info.xsize = static_cast<std::uint32_t>(width);
        info.ysize = static_cast<std::uint32_t>(height);
        info.bits_per_sample = 16;
        info.num_color_channels = 1;
        info.uses_original_profile = JXL_TRUE;
        check(JxlEncoderSetBasicInfo(encoder.get(), &info) == JXL_ENC_SUCCESS, "basic info");
        JxlColorEncoding colour;
        JxlColorEncodingSetToSRGB(&colour, JXL_TRUE);
        check(JxlEncoderSetColorEncoding(encoder.get(), &colour) == JXL_ENC_SUCCESS, "colour encoding");
        JxlEncoderFrameSettings* settings = JxlEncoderFrameSettingsCreate(encoder.get(), nullptr);
        check(JxlEncoderSetFrameLossless(settings, JXL_TRUE) == JXL_ENC_SUCCESS, "lossless");
        check(JxlEncoderFrameSettingsSetOption(settings, JXL_ENC_FRAME_SETTING_EFFORT, effort_) ==
                  JXL_ENC_SUCCESS,
              "effort");
        check(
            JxlEncoderAddImageFrame(settings, &kFormat, pixels.data(), pixels.size() * 2) == JXL_ENC_SUCCESS,
            "frame");
        JxlEncoderCloseInput(encoder.get());
        drain(encoder.get(), pixels.size() * 3 + 4096, out);
    }

    static void drain(JxlEncoder* encoder, std::size_t room, Bytes& out) {
        const std::size_t begin = out.size();
        out.resize(begin + room);
        auto* next = reinterpret_cast<std::uint8_t*>(out.data() + begin);
        std::size_t left = room;
        check(JxlEncoderProcessOutput(encoder, &next, &left) == JXL_ENC_SUCCESS, "no room for the output");
        out.resize(out.size() - left);
    }

    void decode_indices(std::span<const std::byte> bytes, int, int,
                        std::vector<std::uint32_t>& index) override {
        std::vector<std::uint16_t> pixels(index.size());
        const std::unique_ptr<JxlDecoder, Destroy> decoder(JxlDecoderCreate(nullptr));
        check(JxlDecoderSubscribeEvents(decoder.get(), JXL_DEC_FULL_IMAGE) == JXL_DEC_SUCCESS, "events");
        JxlDecoderSetInput(decoder.get(), reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
        JxlDecoderCloseInput(decoder.get());
        check(JxlDecoderProcessInput(decoder.get()) == JXL_DEC_NEED_IMAGE_OUT_BUFFER, "no image");
        check(JxlDecoderSetImageOutBuffer(decoder.get(), &kFormat, pixels.data(), pixels.size() * 2) ==
                  JXL_DEC_SUCCESS,
              "size");
        check(JxlDecoderProcessInput(decoder.get()) == JXL_DEC_FULL_IMAGE, "image");
        std::copy(pixels.begin(), pixels.end(), index.begin());
    }

    int effort_;
};

}  // namespace

std::unique_ptr<Contestant> make_jxl_e3() { return std::make_unique<JpegXl>(3); }
std::unique_ptr<Contestant> make_jxl_e7() { return std::make_unique<JpegXl>(7); }

}  // namespace carat::bench
