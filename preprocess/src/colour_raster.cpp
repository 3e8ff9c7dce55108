#include "colour_raster.hpp"

#include "carat/codec/colour.hpp"
#include "carat/globe/error.hpp"

namespace carat {
namespace {

using Bands = std::array<std::unique_ptr<RasterFile>, kColourPlanes>;

// A hole of any band is one of the colour: bands have their own masks and NODATA.
class ColourRaster final : public RasterFile {
  public:
    ColourRaster(RasterHeader header, Bands bands, std::size_t component)
        : RasterFile(std::move(header), {}), bands_(std::move(bands)), component_(component) {}

  protected:
    void read_samples(const PixelWindow& window, void* samples) const override {
        std::vector<std::uint8_t> valid;
        read_both(window, static_cast<std::int16_t*>(samples), valid);
    }
    void apply_mask(const PixelWindow& window, std::uint8_t* valid) const override {
        if (!header().may_have_holes) return;
        std::vector<std::int16_t> samples(pixels(window));
        std::vector<std::uint8_t> there;
        read_both(window, samples.data(), there);
        for (std::size_t i = 0; i < there.size(); ++i) valid[i] = valid[i] & there[i];
    }

  private:
    static std::size_t pixels(const PixelWindow& w) {
        return static_cast<std::size_t>(w.width) * static_cast<std::size_t>(w.height);
    }

    void read_both(const PixelWindow& window, std::int16_t* out, std::vector<std::uint8_t>& valid) const {
        const std::size_t count = pixels(window);
        valid.assign(count, 1);
        std::array<std::vector<std::int16_t>, kColourPlanes> channels;
        std::vector<std::uint8_t> there(count);
        for (std::size_t c = 0; c < kColourPlanes; ++c) {
            channels[c].resize(count);
            if (bands_[c] == nullptr) {
                channels[c] = channels[0];  // grey
                continue;
            }
            bands_[c]->read(window, channels[c].data(), there.data());
            for (std::size_t i = 0; i < count; ++i) valid[i] = valid[i] & there[i];
        }
        for (std::size_t i = 0; i < count; ++i) {
            const std::array<int, 3> rgb{channels[0][i], channels[1][i], channels[2][i]};
            for (const int x : rgb)
                if (valid[i] != 0 && (x < 0 || x > 255))
                    throw Error(ErrorCode::unsupported, header().path + ": a channel of " +
                                                            std::to_string(x) + ": colours are 8-bit");
            out[i] = static_cast<std::int16_t>(ycocg_of_rgb(rgb)[component_]);
        }
    }

    Bands bands_;
    std::size_t component_;
};

}  // namespace

std::unique_ptr<RasterFile> open_colour_raster(const std::string& path, const LayerOptions& options,
                                               HandlePool& handles, std::vector<std::string>& warnings) {
    LayerOptions band = options;
    band.colour_component.reset();
    Bands bands;
    for (std::size_t c = 0; c < kColourPlanes; ++c) {
        band.band = static_cast<int>(c) + 1;
        try {
            bands[c] = RasterFile::open(path, band, handles, warnings);
        } catch (const Error& error) {
            // Without a second band the first is grey; with two, what the second means is unknown.
            if (c == 1 && error.code() == ErrorCode::usage) break;
            throw;
        }
        if (bands[c]->header().type != SampleType::int16)
            throw Error(ErrorCode::unsupported, path + ": its bands are not 8-bit");
    }
    RasterHeader header = bands[0]->header();
    header.scale = 1;
    header.offset = 0;
    for (const auto& b : bands)
        if (b != nullptr && b->header().may_have_holes) header.may_have_holes = true;
    return std::make_unique<ColourRaster>(std::move(header), std::move(bands),
                                          static_cast<std::size_t>(*options.colour_component));
}

}  // namespace carat
