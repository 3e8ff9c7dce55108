#include "carat/bench/color_bench.hpp"

#include <algorithm>
#include <cmath>

#include "carat/bench/plane.hpp"
#include "carat/globe/error.hpp"
#include "cycles.hpp"
#include "jxl_image.hpp"

namespace carat::bench {
namespace {

constexpr int kEffort = 7;

using Pixel = std::array<std::int16_t, 3>;

Pixel pixel(const Rgb& image, std::size_t k) {
    return {image[0].whole[k], image[1].whole[k], image[2].whole[k]};
}

void put(Rgb& image, std::size_t k, const Pixel& p) {
    for (std::size_t c = 0; c < 3; ++c) image[c].whole[k] = p[c];
}

Rgb like(const Rgb& image) { return {image[0].like(), image[1].like(), image[2].like()}; }

template <class Work>
double seconds(Work work) {
    const double begin = thread_seconds();
    work();
    return thread_seconds() - begin;
}

void measure_error(const Rgb& a, const Rgb& b, ColorRow& row) {
    double squares = 0;
    for (std::size_t c = 0; c < 3; ++c) {
        const Errors e = compare(a[c], b[c]);
        row.max_error = std::max(row.max_error, static_cast<int>(e.max));
        squares += e.rms * e.rms / 3;
    }
    row.rms_error = std::sqrt(squares);
}

void finish(const Rgb& image, ColorRow& row, double encode, double decode) {
    const auto pixels = static_cast<double>(image[0].size());
    row.bits_per_pixel = 8 * static_cast<double>(row.bytes) / pixels;
    row.encode_rate = pixels / encode;
    row.decode_rate = pixels / decode;
}

// One component after the other, each with an index of its own.
ColorRow carat_row(const Rgb& image, Mode mode, const ComponentTolerances& t, bool decode) {
    ColorRow row;
    row.codec = "carat mode " + std::to_string(static_cast<int>(mode));
    row.setting = "Y " + std::to_string(t.y) + " Co " + std::to_string(t.co) + " Cg " + std::to_string(t.cg);
    Rgb components = like(image), decoded = like(image), back = like(image);
    double encode_time = seconds([&] {
        for (std::size_t k = 0; k < image[0].size(); ++k) put(components, k, ycocg_of_rgb(pixel(image, k)));
    });
    double decode_time = 0;
    const int tolerance[] = {t.y, t.co, t.cg};
    for (std::size_t c = 0; c < 3; ++c) {
        KernelChoice choice;
        choice.mode = mode;
        choice.coding = Coding{};
        PlaneCodec codec(components[c], choice, tolerance[c]);
        encode_time += seconds([&] { row.bytes += codec.encode(components[c]); });
        if (decode) decode_time += seconds([&] { codec.decode(decoded[c]); });
    }
    if (!decode) return row;
    decode_time += seconds([&] {
        for (std::size_t k = 0; k < image[0].size(); ++k) put(back, k, rgb_of_ycocg(pixel(decoded, k)));
    });
    for (Raster& channel : back)
        for (std::int16_t& x : channel.whole) x = std::clamp<std::int16_t>(x, 0, 255);
    measure_error(image, back, row);
    finish(image, row, encode_time, decode_time);
    return row;
}

std::vector<std::uint8_t> interleaved(const Rgb& image) {
    std::vector<std::uint8_t> out(3 * image[0].size());
    for (std::size_t k = 0; k < image[0].size(); ++k)
        for (std::size_t c = 0; c < 3; ++c) out[3 * k + c] = static_cast<std::uint8_t>(image[c].whole[k]);
    return out;
}

Rgb planes(const std::vector<std::uint8_t>& pixels, const Rgb& shape) {
    Rgb out = like(shape);
    for (std::size_t k = 0; k < out[0].size(); ++k)
        for (std::size_t c = 0; c < 3; ++c) out[c].whole[k] = pixels[3 * k + c];
    return out;
}

ColorRow jxl_row(const Rgb& image, const std::vector<std::uint8_t>& pixels, float distance) {
    ColorRow row;
    row.codec = "jxl lossy e7";
    char text[32];
    std::snprintf(text, sizeof text, "distance %.4f", static_cast<double>(distance));
    row.setting = text;
    std::vector<std::byte> bytes;
    std::vector<std::uint8_t> back;
    const double encode =
        seconds([&] { bytes = jxl_encode_rgb(pixels, image[0].width, image[0].height, distance, kEffort); });
    const double decode = seconds([&] { back = jxl_decode_rgb(bytes, pixels.size()); });
    row.bytes = bytes.size();
    measure_error(image, planes(back, image), row);
    finish(image, row, encode, decode);
    return row;
}

// The greatest distance, to 3 %, that keeps the tolerance; distances below 0.01 are not tried.
ColorRow jxl_search(const Rgb& image, int tolerance) {
    const std::vector<std::uint8_t> pixels = interleaved(image);
    constexpr float kLeast = 0.01f, kGreatest = 8;
    float low = kLeast, high = kGreatest;
    ColorRow best = jxl_row(image, pixels, low);
    while (high / low > 1.03f) {
        const float middle = std::sqrt(low * high);
        const ColorRow row = jxl_row(image, pixels, middle);
        if (row.max_error <= tolerance) {
            best = row;
            low = middle;
        } else {
            high = middle;
        }
    }
    return best;
}

ColorRow jxl_quantised(const Rgb& image, int tolerance) {
    ColorRow row;
    const int step = 2 * tolerance + 1;
    row.codec = "jxl lossless e7";
    row.setting = "RGB quantised, step " + std::to_string(step);
    Rgb index = like(image);
    for (std::size_t c = 0; c < 3; ++c)
        std::transform(image[c].whole.begin(), image[c].whole.end(), index[c].whole.begin(),
                       [&](std::int16_t x) { return static_cast<std::int16_t>((x + tolerance) / step); });
    const std::vector<std::uint8_t> pixels = interleaved(index);
    std::vector<std::byte> bytes;
    std::vector<std::uint8_t> back;
    const double encode =
        seconds([&] { bytes = jxl_encode_rgb(pixels, image[0].width, image[0].height, 0, kEffort); });
    const double decode = seconds([&] { back = jxl_decode_rgb(bytes, pixels.size()); });
    row.bytes = bytes.size();
    Rgb out = planes(back, image);
    for (Raster& channel : out)
        for (std::int16_t& x : channel.whole) x = static_cast<std::int16_t>(std::min(255, x * step));
    measure_error(image, out, row);
    finish(image, row, encode, decode);
    return row;
}

// The split with the smallest file, on a sample of the image: its middle.
ComponentTolerances best_split(const Rgb& image, Mode mode, int tolerance) {
    constexpr int kSample = 513;
    const int w = std::min(kSample, image[0].width), h = std::min(kSample, image[0].height);
    Rgb sample;
    for (std::size_t c = 0; c < 3; ++c) {
        sample[c] = image[c].like(w, h);
        for (int y = 0; y < h; ++y)
            for (int x = 0; x < w; ++x)
                sample[c].whole[static_cast<std::size_t>(y * w + x)] =
                    image[c].whole[static_cast<std::size_t>(y + (image[c].height - h) / 2) *
                                       static_cast<std::size_t>(image[c].width) +
                                   static_cast<std::size_t>(x + (image[c].width - w) / 2)];
    }
    ComponentTolerances best;
    std::size_t least = SIZE_MAX;
    for (const ComponentTolerances& t : component_tolerances(tolerance))
        if (const std::size_t bytes = carat_row(sample, mode, t, false).bytes; bytes < least) {
            least = bytes;
            best = t;
        }
    return best;
}

}  // namespace

std::array<std::int16_t, 3> ycocg_of_rgb(const std::array<std::int16_t, 3>& p) {
    const int co = p[0] - p[2], t = p[2] + (co >> 1), cg = p[1] - t, y = t + (cg >> 1);
    return {static_cast<std::int16_t>(y), static_cast<std::int16_t>(co), static_cast<std::int16_t>(cg)};
}

std::array<std::int16_t, 3> rgb_of_ycocg(const std::array<std::int16_t, 3>& p) {
    const int t = p[0] - (p[2] >> 1), g = p[2] + t, b = t - (p[1] >> 1), r = b + p[1];
    return {static_cast<std::int16_t>(r), static_cast<std::int16_t>(g), static_cast<std::int16_t>(b)};
}

std::vector<ComponentTolerances> component_tolerances(int tolerance) {
    std::vector<ComponentTolerances> out;
    for (int y = tolerance; y >= 0; --y)
        for (int half_co = 0; half_co <= tolerance - y; ++half_co)
            out.push_back({y, 2 * half_co, 2 * (tolerance - y - half_co)});
    return out;
}

Rgb read_rgb(const std::string& file, const std::optional<Crop>& crop) {
    Rgb out;
    for (int c = 0; c < 3; ++c) {
        std::size_t filled = 0;
        Raster& channel = out[static_cast<std::size_t>(c)] = read_raster(file, crop, filled, c + 1);
        if (!channel.integer || std::any_of(channel.whole.begin(), channel.whole.end(),
                                            [](std::int16_t x) { return x < 0 || x > 255; }))
            throw Error(ErrorCode::unsupported, file + ": its bands are not 8-bit");
    }
    return out;
}

std::vector<ColorRow> bench_color(const Rgb& image, const ColorOptions& options) {
    std::vector<ColorRow> rows;
    const auto say = [&](const std::string& what) {
        constexpr std::size_t kRows = 5;
        if (options.progress && !options.progress(what, rows.size(), kRows))
            throw Error(ErrorCode::usage, "cancelled");
    };
    for (const Mode mode : {Mode::interpolating, Mode::filtered, Mode::paper}) {
        say("carat mode " + std::to_string(static_cast<int>(mode)));
        rows.push_back(carat_row(image, mode, best_split(image, mode, options.tolerance), true));
    }
    say("jxl lossy");
    rows.push_back(jxl_search(image, options.tolerance));
    say("jxl lossless");
    rows.push_back(jxl_quantised(image, options.tolerance));
    return rows;
}

}  // namespace carat::bench
