// One raster file: its header, and windows of its samples with their holes marked.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <list>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "carat/preprocess/layer.hpp"

class GDALDataset;

namespace carat {

// How samples are kept: the smallest of these that holds every value of the file's type. 64-bit integers
// become doubles, exact to 2^53.
enum class SampleType : std::uint8_t { int16, int32, float32, float64 };
constexpr std::size_t size_of(SampleType t) {
    return t == SampleType::int16 ? 2 : t == SampleType::float64 ? 8 : 4;
}

struct PixelWindow {
    std::int64_t x = 0, y = 0;
    int width = 0, height = 0;
};

struct RasterHeader {
    std::string path, driver;
    int width = 0, height = 0;
    SampleType type = SampleType::int16;
    double scale = 1, offset = 0;                    // metres = offset + scale * sample
    std::optional<std::array<double, 6>> transform;  // pixel edges to CRS, GDAL's six numbers
    std::string wkt;                                 // "" if the file names no CRS
    int block_width = 0, block_height = 0;           // how the file stores them
    bool may_have_holes = false;
    std::vector<std::string> files;  // all files the dataset consists of
};

// Open GDAL datasets, which only one thread may use at a time. Keeps a bounded number of idle ones.
// Thread-safe.
class HandlePool {
  public:
    struct Closer {
        void operator()(GDALDataset* d) const;
    };
    using Handle = std::unique_ptr<GDALDataset, Closer>;

    // Throws Error(io) with GDAL's reason.
    Handle acquire(const std::string& path);
    void release(const std::string& path, Handle handle);

  private:
    struct Idle {
        std::string path;
        Handle handle;
    };
    static constexpr std::size_t kMaxIdle = 64;
    std::mutex mutex_;
    std::list<Idle> idle_;  // latest first
};

// Thread-safe.
class RasterFile {
  public:
    // Opens with GDAL; with options.bounds, and where GDAL knows no such format, with OpenImageIO.
    // Throws Error(io, unsupported, usage) naming the file. The pool must outlive the file.
    static std::unique_ptr<RasterFile> open(const std::string& path, const LayerOptions& options,
                                            HandlePool& handles, std::vector<std::string>& warnings);
    virtual ~RasterFile() = default;

    const RasterHeader& header() const { return header_; }

    // Row-major samples of a window inside the raster, of header().type, and 1 for a sample, 0 for a hole.
    // Throws Error(io) naming the file.
    void read(const PixelWindow& window, void* samples, std::uint8_t* valid) const;

  protected:
    RasterFile(RasterHeader header, const LayerOptions& options);
    virtual void read_samples(const PixelWindow& window, void* samples) const = 0;
    // Clears `valid` where the file's own mask says so.
    virtual void apply_mask(const PixelWindow&, std::uint8_t*) const {}

    void add_nodata(double value);

  private:
    template <class T>
    void mark_holes(const T* samples, std::size_t count, std::uint8_t* valid) const;

    RasterHeader header_;
    std::vector<double> nodata_;
    std::optional<std::array<double, 2>> valid_range_;
};

}  // namespace carat
