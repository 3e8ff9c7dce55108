#include "image_raster.hpp"

#include <OpenImageIO/imagecache.h>
#include <OpenImageIO/imageio.h>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr int kTile = 256;
constexpr float kCacheMegabytes = 64;

struct CacheDeleter {
    void operator()(OIIO::ImageCache* c) const { OIIO::ImageCache::destroy(c); }
};

std::unique_ptr<OIIO::ImageCache, CacheDeleter> make_cache() {
    std::unique_ptr<OIIO::ImageCache, CacheDeleter> cache(OIIO::ImageCache::create(false));
    cache->attribute("autotile", kTile);
    cache->attribute("max_memory_MB", kCacheMegabytes);
    cache->attribute("forcefloat", 0);
    cache->attribute("unassociatedalpha", 1);
    return cache;
}

SampleType sample_type(const OIIO::TypeDesc& format) {
    if (format == OIIO::TypeDesc::UINT8) return SampleType::int16;
    if (format == OIIO::TypeDesc::UINT16) return SampleType::int32;
    return SampleType::float32;
}

// OpenImageIO maps integers to 0..1 where it converts types; so samples are fetched in their own type.
template <class Stored, class Kept>
void widen(const std::vector<std::byte>& raw, void* samples, std::size_t count) {
    const auto* from = reinterpret_cast<const Stored*>(raw.data());
    std::copy(from, from + count, static_cast<Kept*>(samples));
}

class ImageRaster final : public RasterFile {
  public:
    // x, y: corner of the image's data window, where OpenImageIO counts pixels from.
    ImageRaster(RasterHeader header, const LayerOptions& options, int x, int y)
        : RasterFile(std::move(header), options),
          x_(x),
          y_(y),
          channel_(options.band - 1),
          cache_(make_cache()) {}

  protected:
    void read_samples(const PixelWindow& window, void* samples) const override {
        const std::size_t count =
            static_cast<std::size_t>(window.width) * static_cast<std::size_t>(window.height);
        const OIIO::TypeDesc type = header().type == SampleType::int16   ? OIIO::TypeDesc::UINT8
                                    : header().type == SampleType::int32 ? OIIO::TypeDesc::UINT16
                                                                         : OIIO::TypeDesc::FLOAT;
        std::vector<std::byte> raw(count * type.size());
        const int x = x_ + static_cast<int>(window.x), y = y_ + static_cast<int>(window.y);
        if (!cache_->get_pixels(OIIO::ustring(header().path), 0, 0, x, x + window.width, y, y + window.height,
                                0, 1, channel_, channel_ + 1, type, raw.data()))
            throw Error(ErrorCode::io, header().path + ": cannot read samples: " + cache_->geterror());
        if (header().type == SampleType::int16) return widen<std::uint8_t, std::int16_t>(raw, samples, count);
        if (header().type == SampleType::int32)
            return widen<std::uint16_t, std::int32_t>(raw, samples, count);
        widen<float, float>(raw, samples, count);
    }

  private:
    int x_, y_, channel_;
    std::unique_ptr<OIIO::ImageCache, CacheDeleter> cache_;
};

}  // namespace

std::unique_ptr<RasterFile> open_image_raster(const std::string& path, const LayerOptions& options) {
    const auto input = OIIO::ImageInput::open(path);
    if (!input) {
        OIIO::geterror();
        return nullptr;
    }
    const OIIO::ImageSpec& spec = input->spec();
    if (spec.depth > 1) throw Error(ErrorCode::unsupported, path + ": a volume is not a raster of heights");
    if (options.band < 1 || options.band > spec.nchannels)
        throw Error(ErrorCode::usage, path + ": no channel " + std::to_string(options.band) + ", only " +
                                          std::to_string(spec.nchannels));
    RasterHeader header;
    header.path = path;
    header.driver = std::string("OpenImageIO:") + input->format_name();
    header.width = spec.width;
    header.height = spec.height;
    header.type = sample_type(spec.format);
    header.block_width = header.block_height = kTile;
    header.files = {path};
    return std::make_unique<ImageRaster>(std::move(header), options, spec.x, spec.y);
}

}  // namespace carat
