// Pictures in memory and in files.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <variant>
#include <vector>

namespace carat {

// Rows from the top, channels interleaved; row-major. Colour channels are linear light, Rec. 709 primaries, 1
// = white.
struct Picture {
    int width = 0, height = 0;          // pixels
    std::vector<std::string> channels;  // "R", "G", "B", "A", "Z", ...: names by OpenEXR convention
    std::vector<float> values;          // width * height * channels.size()
    // Kept by .exr alone: text, numbers, and matrices for row vectors, by rows (OpenEXR's convention).
    using Attribute = std::variant<std::string, float, std::array<float, 16>>;
    std::vector<std::pair<std::string, Attribute>> attributes = {};

    const float* at(int x, int y) const {
        return values.data() +
               (static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)) *
                   channels.size();
    }
};

// sRGB transfer function (IEC 61966-2-1), linear [0, 1] to encoded [0, 1]; clamps, NaN to 0.
float srgb_encode(float linear);
// Its inverse.
float srgb_decode(float encoded);

// From linear light without bound to [0, 1], by pixel; hues shift as light saturates, as on film.
enum class Tone {
    none,      // clipped
    reinhard,  // x (1 + x / 16) / (1 + x) of the luminance: white at 4 (Reinhard et al. 2002, eq. 4)
    aces,      // a curve close to the ACES reference transform (K. Narkowicz 2015), 1 becomes 0.80
};
// Of channels R, G and B; others stay. Uses the threads of the current TBB arena.
void tone_map(Picture& picture, Tone tone);

// Each pixel the mean of a square of factor x factor; pixels left over at the right and below are dropped.
// factor >= 1. Attributes stay. Uses the threads of the current TBB arena.
Picture shrunk(const Picture& picture, int factor);

enum class PixelType { automatic, half, float32 };

// Writes a picture through OpenImageIO; the format follows from the file's extension.
//   .exr              linear, half for colour (R, G, B, A) and float for everything else unless `type` says
//   .png and others   8 bits a channel, sRGB-encoded
// Written under a temporary name beside `path` and renamed when complete. Throws Error(usage) for an empty
// picture or an unknown extension and Error(io) when the file cannot be written. Thread-safe.
void write_picture(const std::string& path, const Picture& picture, PixelType type = PixelType::automatic);

}  // namespace carat
