#include "carat/vulkan/picture.hpp"

#include <OpenImageIO/imageio.h>
#include <fmt/format.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <random>

#include "carat/globe/error.hpp"

namespace carat {

namespace {

namespace fs = std::filesystem;

bool is_exr(const std::string& path) { return fs::path(path).extension() == ".exr"; }

bool is_colour(const std::string& channel) {
    return channel == "R" || channel == "G" || channel == "B" || channel == "A";
}

// A name beside `path` that keeps the extension, by which OpenImageIO chooses the format.
fs::path temporary_name(const fs::path& path) {
    std::random_device random;
    return path.parent_path() /
           fmt::format(".{}.{:08x}{}", path.stem().string(), random(), path.extension().string());
}

OIIO::ImageSpec specification(const Picture& p, bool exr, PixelType type) {
    OIIO::ImageSpec spec(p.width, p.height, static_cast<int>(p.channels.size()),
                         exr ? OIIO::TypeDesc::FLOAT : OIIO::TypeDesc::UINT8);
    spec.channelnames = p.channels;
    for (std::size_t c = 0; c < p.channels.size(); ++c) {
        if (p.channels[c] == "A") spec.alpha_channel = static_cast<int>(c);
        if (!exr) continue;
        const bool half =
            type == PixelType::half || (type == PixelType::automatic && is_colour(p.channels[c]));
        spec.channelformats.emplace_back(half ? OIIO::TypeDesc::HALF : OIIO::TypeDesc::FLOAT);
    }
    if (exr) {
        spec.attribute("compression", "zip");
        for (const auto& [name, value] : p.attributes) {
            if (const auto* text = std::get_if<std::string>(&value)) spec.attribute(name, *text);
            if (const auto* number = std::get_if<float>(&value)) spec.attribute(name, *number);
            if (const auto* matrix = std::get_if<std::array<float, 16>>(&value))
                spec.attribute(name, OIIO::TypeMatrix, matrix->data());
        }
    } else {
        spec.attribute("oiio:ColorSpace", "sRGB");
        spec.attribute("oiio:UnassociatedAlpha", 1);  // values are stored as they are
    }
    return spec;
}

std::vector<std::uint8_t> encoded(const Picture& p) {
    std::vector<std::uint8_t> bytes(p.values.size());
    const std::size_t channels = p.channels.size();
    const auto alpha = std::find(p.channels.begin(), p.channels.end(), "A") - p.channels.begin();
    const auto rows = static_cast<std::size_t>(p.height), row = bytes.size() / rows;
    tbb::parallel_for(std::size_t{0}, rows, [&](std::size_t y) {
        for (std::size_t i = y * row; i < (y + 1) * row; ++i) {
            const bool coverage = i % channels == static_cast<std::size_t>(alpha);
            const float v = p.values[i];
            const float e = coverage ? std::min(std::max(v, 0.0f), 1.0f) : srgb_encode(v);
            bytes[i] = static_cast<std::uint8_t>(std::lround(e * 255.0f));
        }
    });
    return bytes;
}

void write_file(const fs::path& file, const std::string& path, const Picture& p, PixelType type) {
    const bool exr = is_exr(path);
    auto out = OIIO::ImageOutput::create(file.string());
    if (!out)
        throw Error(ErrorCode::usage, path + ": no picture format for this extension: " + OIIO::geterror());
    if (!out->open(file.string(), specification(p, exr, type))) {
        throw Error(ErrorCode::io, path + ": cannot create: " + out->geterror());
    }
    const bool written = exr ? out->write_image(OIIO::TypeDesc::FLOAT, p.values.data())
                             : out->write_image(OIIO::TypeDesc::UINT8, encoded(p).data());
    if (!written || !out->close()) throw Error(ErrorCode::io, path + ": cannot write: " + out->geterror());
}

}  // namespace

float srgb_encode(float linear) {
    if (!(linear > 0)) return 0;
    if (linear >= 1) return 1;
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1 / 2.4f) - 0.055f;
}

float srgb_decode(float encoded) {
    if (!(encoded > 0)) return 0;
    if (encoded >= 1) return 1;
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

namespace {

float aces(float x) {
    x = std::max(x, 0.0f);
    return std::min(x * (2.51f * x + 0.03f) / (x * (2.43f * x + 0.59f) + 0.14f), 1.0f);
}

void tone_pixel(float* rgb, Tone tone) {
    if (tone == Tone::aces) {
        for (int c = 0; c < 3; ++c) rgb[c] = aces(rgb[c]);
        return;
    }
    const float luminance = 0.2126f * rgb[0] + 0.7152f * rgb[1] + 0.0722f * rgb[2];
    if (!(luminance > 0)) return;
    const float factor = (1 + luminance / 16) / (1 + luminance);
    for (int c = 0; c < 3; ++c) rgb[c] = std::min(rgb[c] * factor, 1.0f);
}

}  // namespace

void tone_map(Picture& picture, Tone tone) {
    const std::size_t channels = picture.channels.size();
    if (tone == Tone::none || picture.values.empty()) return;
    if (channels < 3 || picture.channels[0] != "R" || picture.channels[1] != "G" ||
        picture.channels[2] != "B")
        throw Error(ErrorCode::usage, "only pictures that begin with R, G and B have tones to map");
    const std::size_t row = static_cast<std::size_t>(picture.width) * channels;
    tbb::parallel_for(std::size_t{0}, static_cast<std::size_t>(picture.height), [&](std::size_t y) {
        for (std::size_t i = y * row; i < (y + 1) * row; i += channels) tone_pixel(&picture.values[i], tone);
    });
}

Picture shrunk(const Picture& p, int factor) {
    if (factor == 1) return p;
    Picture out{p.width / factor, p.height / factor, p.channels, {}, p.attributes};
    const std::size_t channels = p.channels.size(), row = static_cast<std::size_t>(out.width) * channels;
    out.values.resize(static_cast<std::size_t>(out.height) * row);
    const float share = 1.0f / static_cast<float>(factor * factor);
    tbb::parallel_for(0, out.height, [&](int y) {
        float* to = out.values.data() + static_cast<std::size_t>(y) * row;
        for (int x = 0; x < out.width; ++x)
            for (std::size_t c = 0; c < channels; ++c) {
                float sum = 0;
                for (int k = 0; k < factor * factor; ++k)
                    sum += p.at(x * factor + k % factor, y * factor + k / factor)[c];
                *to++ = sum * share;
            }
    });
    return out;
}

void write_picture(const std::string& path, const Picture& picture, PixelType type) {
    const auto count = static_cast<std::size_t>(picture.width) * static_cast<std::size_t>(picture.height);
    if (picture.width <= 0 || picture.height <= 0 || picture.channels.empty() ||
        picture.values.size() != count * picture.channels.size()) {
        throw Error(ErrorCode::usage, path + ": an empty or inconsistent picture cannot be written");
    }
    const fs::path file = temporary_name(path);
    std::error_code ignored;
    try {
        write_file(file, path, picture, type);
        fs::rename(file, path);
    } catch (const fs::filesystem_error& e) {
        fs::remove(file, ignored);
        throw Error(ErrorCode::io, path + ": cannot rename: " + e.code().message());
    } catch (...) {
        fs::remove(file, ignored);
        throw;
    }
}

}  // namespace carat
