#include "jxl_image.hpp"

#include <jxl/decode.h>
#include <jxl/encode.h>

#include <memory>
#include <string>

#include "carat/globe/error.hpp"

namespace carat::bench {
namespace {

constexpr JxlPixelFormat kFormat{3, JXL_TYPE_UINT8, JXL_LITTLE_ENDIAN, 0};

struct Destroy {
    void operator()(JxlEncoder* e) const { JxlEncoderDestroy(e); }
    void operator()(JxlDecoder* d) const { JxlDecoderDestroy(d); }
};

void check(bool good, const char* what) {
    if (!good) throw Error(ErrorCode::corrupt, std::string("JPEG XL: ") + what);
}

}  // namespace

std::vector<std::byte> jxl_encode_rgb(const std::vector<std::uint8_t>& pixels, int width, int height,
                                      float distance, int effort) {
    const bool lossless = distance <= 0;
    const std::unique_ptr<JxlEncoder, Destroy> encoder(JxlEncoderCreate(nullptr));
    JxlBasicInfo info;
    JxlEncoderInitBasicInfo(&info);
    info.xsize = static_cast<std::uint32_t>(width);
    info.ysize = static_cast<std::uint32_t>(height);
    info.bits_per_sample = 8;
    info.num_color_channels = 3;
    info.uses_original_profile = lossless ? JXL_TRUE : JXL_FALSE;
    check(JxlEncoderSetBasicInfo(encoder.get(), &info) == JXL_ENC_SUCCESS, "basic info");
    JxlColorEncoding colour;
    JxlColorEncodingSetToSRGB(&colour, JXL_FALSE);
    check(JxlEncoderSetColorEncoding(encoder.get(), &colour) == JXL_ENC_SUCCESS, "colour encoding");
    JxlEncoderFrameSettings* settings = JxlEncoderFrameSettingsCreate(encoder.get(), nullptr);
    check(JxlEncoderFrameSettingsSetOption(settings, JXL_ENC_FRAME_SETTING_EFFORT, effort) == JXL_ENC_SUCCESS,
          "effort");
    if (lossless)
        check(JxlEncoderSetFrameLossless(settings, JXL_TRUE) == JXL_ENC_SUCCESS, "lossless");
    else
        check(JxlEncoderSetFrameDistance(settings, distance) == JXL_ENC_SUCCESS, "distance");
    check(JxlEncoderAddImageFrame(settings, &kFormat, pixels.data(), pixels.size()) == JXL_ENC_SUCCESS,
          "frame");
    JxlEncoderCloseInput(encoder.get());
    std::vector<std::byte> out(pixels.size() * 2 + 65536);
    auto* next = reinterpret_cast<std::uint8_t*>(out.data());
    std::size_t left = out.size();
    check(JxlEncoderProcessOutput(encoder.get(), &next, &left) == JXL_ENC_SUCCESS, "no room for the output");
    out.resize(out.size() - left);
    return out;
}

std::vector<std::uint8_t> jxl_decode_rgb(const std::vector<std::byte>& bytes, std::size_t samples) {
    std::vector<std::uint8_t> pixels(samples);
    const std::unique_ptr<JxlDecoder, Destroy> decoder(JxlDecoderCreate(nullptr));
    check(JxlDecoderSubscribeEvents(decoder.get(), JXL_DEC_FULL_IMAGE) == JXL_DEC_SUCCESS, "events");
    JxlDecoderSetInput(decoder.get(), reinterpret_cast<const std::uint8_t*>(bytes.data()), bytes.size());
    JxlDecoderCloseInput(decoder.get());
    check(JxlDecoderProcessInput(decoder.get()) == JXL_DEC_NEED_IMAGE_OUT_BUFFER, "no image");
    check(
        JxlDecoderSetImageOutBuffer(decoder.get(), &kFormat, pixels.data(), pixels.size()) == JXL_DEC_SUCCESS,
        "size");
    check(JxlDecoderProcessInput(decoder.get()) == JXL_DEC_FULL_IMAGE, "image");
    return pixels;
}

}  // namespace carat::bench
