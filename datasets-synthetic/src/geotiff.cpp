#include "geotiff.hpp"

#include <gdal_priv.h>
#include <ogr_spatialref.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <vector>

#include "carat/globe/error.hpp"

namespace carat::synth {
namespace {

namespace fs = std::filesystem;

constexpr int kTile = 256;      // pixels; strips are a row of tiles
constexpr int kRowsAtOnce = 8;  // rows a task computes

[[noreturn]] void fail(const fs::path& path, const std::string& what) {
    const char* cause = CPLGetLastErrorMsg();
    throw Error(ErrorCode::io,
                path.string() + ": " + what + (cause && *cause ? std::string(": ") + cause : ""));
}

/// Keeps GDAL from printing, and from writing files of its own beside ours, while it lives.
class QuietGdal {
  public:
    QuietGdal() {
        CPLPushErrorHandler(CPLQuietErrorHandler);
        CPLErrorReset();
        CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", "NO");
    }
    ~QuietGdal() {
        CPLSetThreadLocalConfigOption("GDAL_PAM_ENABLED", nullptr);
        CPLPopErrorHandler();
    }
    QuietGdal(const QuietGdal&) = delete;
    QuietGdal& operator=(const QuietGdal&) = delete;
};

struct Closer {
    void operator()(GDALDataset* d) const { GDALClose(d); }
};
using Dataset = std::unique_ptr<GDALDataset, Closer>;

Dataset create(const Layer& layer, const fs::path& path) {
    GDALDriver* driver = GetGDALDriverManager()->GetDriverByName("GTiff");
    if (!driver) fail(path, "this GDAL cannot write GeoTIFF");
    const bool real = layer.info.type == SampleType::float32;
    CPLStringList options;
    options.SetNameValue("COMPRESS", "DEFLATE");
    options.SetNameValue("ZLEVEL", "6");
    options.SetNameValue("PREDICTOR", real ? "3" : "2");
    options.SetNameValue("BIGTIFF", "IF_SAFER");
    if (layer.grid.width >= kTile && layer.grid.height >= kTile) options.SetNameValue("TILED", "YES");
    Dataset d(driver->Create(path.c_str(), layer.grid.width, layer.grid.height, 1,
                             real ? GDT_Float32 : GDT_Int16, options.List()));
    if (!d) fail(path, "cannot create");
    std::array<double, 6> transform = layer.grid.transform;
    OGRSpatialReference crs;
    crs.SetFromUserInput(layer.grid.crs.definition.c_str());
    crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (d->SetGeoTransform(transform.data()) != CE_None || d->SetSpatialRef(&crs) != CE_None)
        fail(path, "cannot write the georeference");
    if (layer.info.nodata && d->GetRasterBand(1)->SetNoDataValue(*layer.info.nodata) != CE_None)
        fail(path, "cannot write the NODATA value");
    return d;
}

/// A height as the raster stores it, before conversion to the raster's type.
double sample(const Written& info, double height) {
    if (std::isnan(height) && info.nodata) return *info.nodata;
    return info.type == SampleType::int16 ? std::clamp(std::round(height), -32768.0, 32767.0) : height;
}

template <typename T>
std::vector<T> strip(const Layer& layer, int first, int rows) {
    const auto width = static_cast<std::size_t>(layer.grid.width);
    std::vector<T> out(width * static_cast<std::size_t>(rows));
    tbb::parallel_for(tbb::blocked_range<int>(0, rows, kRowsAtOnce), [&](const tbb::blocked_range<int>& r) {
        const std::vector<Vec3> n = layer.grid.normals(first + r.begin(), r.end() - r.begin());
        T* to = out.data() + width * static_cast<std::size_t>(r.begin());
        for (std::size_t k = 0; k < n.size(); ++k)
            to[k] = static_cast<T>(sample(layer.info, layer.info.truth(n[k])));
    });
    return out;
}

template <typename T>
void write_samples(const Layer& layer, GDALDataset& d, GDALDataType type, const fs::path& path,
                   const std::function<void(std::uint64_t)>& advance) {
    GDALRasterBand* band = d.GetRasterBand(1);
    for (int first = 0; first < layer.grid.height; first += kTile) {
        const int rows = std::min(kTile, layer.grid.height - first);
        std::vector<T> samples = strip<T>(layer, first, rows);
        if (band->RasterIO(GF_Write, 0, first, layer.grid.width, rows, samples.data(), layer.grid.width, rows,
                           type, 0, 0, nullptr) != CE_None)
            fail(path, "cannot write");
        advance(samples.size());
    }
}

void damage(const fs::path& path, Damage how) {
    const std::uintmax_t size = fs::file_size(path);
    if (how == Damage::empty) fs::resize_file(path, 0);
    if (how == Damage::cut_header) fs::resize_file(path, std::min<std::uintmax_t>(size, 100));
    if (how == Damage::cut_data) fs::resize_file(path, size - size / 4);
}

/// Removes a file unless told that it has become the result.
class Temporary {
  public:
    explicit Temporary(fs::path path) : path_(std::move(path)) {}
    ~Temporary() {
        std::error_code ignored;
        if (!kept_) fs::remove(path_, ignored);
    }
    Temporary(const Temporary&) = delete;
    Temporary& operator=(const Temporary&) = delete;
    const fs::path& path() const { return path_; }
    void keep_as(const fs::path& name) {
        fs::rename(path_, name);
        kept_ = true;
    }

  private:
    fs::path path_;
    bool kept_ = false;
};

}  // namespace

void write_geotiff(const Layer& layer, const fs::path& directory,
                   const std::function<void(std::uint64_t)>& advance) {
    GDALAllRegister();
    const QuietGdal quiet;
    Temporary temporary(directory / (layer.info.name + ".part"));
    Dataset d = create(layer, temporary.path());
    if (layer.info.type == SampleType::float32)
        write_samples<float>(layer, *d, GDT_Float32, temporary.path(), advance);
    else
        write_samples<std::int16_t>(layer, *d, GDT_Int16, temporary.path(), advance);
    CPLErrorReset();
    d.reset();
    if (CPLGetLastErrorType() >= CE_Failure) fail(temporary.path(), "cannot finish");
    damage(temporary.path(), layer.damage);
    temporary.keep_as(directory / layer.info.name);
}

}  // namespace carat::synth
