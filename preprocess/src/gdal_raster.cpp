#include "gdal_raster.hpp"

#include <gdal_priv.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "carat/globe/error.hpp"
#include "gdal_errors.hpp"

namespace carat {
namespace {

SampleType sample_type(GDALRasterBand& band, const std::string& path) {
    const char* pixel_type = band.GetMetadataItem("PIXELTYPE", "IMAGE_STRUCTURE");
    if (pixel_type != nullptr && EQUAL(pixel_type, "SIGNEDBYTE"))
        throw Error(ErrorCode::unsupported, path + ": signed 8-bit samples");
    switch (band.GetRasterDataType()) {
        case GDT_Byte:
        case GDT_Int16:
            return SampleType::int16;
        case GDT_UInt16:
        case GDT_Int32:
            return SampleType::int32;
        case GDT_Float32:
            return SampleType::float32;
        case GDT_UInt32:
        case GDT_Int64:
        case GDT_UInt64:
        case GDT_Float64:
            return SampleType::float64;
        default:
            break;
    }
    throw Error(
        ErrorCode::unsupported,
        path + ": samples of type " + GDALGetDataTypeName(band.GetRasterDataType()) + " are not heights");
}

GDALDataType gdal_type(SampleType type) {
    switch (type) {
        case SampleType::int16:
            return GDT_Int16;
        case SampleType::int32:
            return GDT_Int32;
        case SampleType::float32:
            return GDT_Float32;
        case SampleType::float64:
            break;
    }
    return GDT_Float64;
}

// Metres per unit of a band; nothing if the unit is unknown.
std::optional<double> metres_per_unit(std::string unit) {
    std::transform(unit.begin(), unit.end(), unit.begin(), [](unsigned char c) { return std::tolower(c); });
    for (const char* metre : {"", "m", "meter", "metre", "meters", "metres"})
        if (unit == metre) return 1.0;
    for (const char* foot : {"ft", "foot", "feet", "international foot"})
        if (unit == foot) return 0.3048;
    for (const char* foot : {"us-ft", "sft", "ftus", "us survey foot", "us survey feet", "foot_us"})
        if (unit == foot) return 1200.0 / 3937.0;
    if (unit == "km" || unit == "kilometre" || unit == "kilometer") return 1000.0;
    if (unit == "cm" || unit == "centimetre" || unit == "centimeter") return 0.01;
    return std::nullopt;
}

void read_scale(GDALRasterBand& band, RasterHeader& header, std::vector<std::string>& warnings) {
    header.scale = band.GetScale();
    header.offset = band.GetOffset();
    const std::string unit = band.GetUnitType();
    const std::optional<double> metres = metres_per_unit(unit);
    if (!metres) warnings.push_back(header.path + ": heights in unit '" + unit + "' are taken as metres");
    header.scale *= metres.value_or(1);
    header.offset *= metres.value_or(1);
    if (!std::isfinite(header.scale) || !std::isfinite(header.offset) || header.scale == 0)
        throw Error(ErrorCode::corrupt, header.path + ": scale " + std::to_string(header.scale) +
                                            " and offset " + std::to_string(header.offset) +
                                            " of its heights are senseless");
}

void read_georeference(GDALDataset& dataset, RasterHeader& header) {
    std::array<double, 6> transform{};
    if (dataset.GetGeoTransform(transform.data()) == CE_None) header.transform = transform;
    const OGRSpatialReference* srs = dataset.GetSpatialRef();
    if (srs == nullptr || srs->IsEmpty()) return;
    char* text = nullptr;
    const char* const options[] = {"FORMAT=WKT2_2019", nullptr};
    srs->exportToWkt(&text, options);
    header.wkt = text != nullptr ? text : "";
    CPLFree(text);
}

std::vector<std::string> file_list(GDALDataset& dataset) {
    std::vector<std::string> files;
    char** list = dataset.GetFileList();
    for (char** f = list; f != nullptr && *f != nullptr; ++f) files.emplace_back(*f);
    CSLDestroy(list);
    return files;
}

GDALRasterBand& height_band(GDALDataset& dataset, const std::string& path, int number) {
    if (dataset.GetRasterCount() == 0) {
        char** subdatasets = dataset.GetMetadata("SUBDATASETS");
        const char* first = CSLFetchNameValue(subdatasets, "SUBDATASET_1_NAME");
        throw Error(
            ErrorCode::unsupported,
            path + ": no raster band" +
                (first != nullptr ? "; name one of its subdatasets instead, such as " + std::string(first)
                                  : ""));
    }
    if (number < 1 || number > dataset.GetRasterCount())
        throw Error(ErrorCode::usage, path + ": no band " + std::to_string(number) + ", only " +
                                          std::to_string(dataset.GetRasterCount()));
    return *dataset.GetRasterBand(number);
}

class GdalRaster final : public RasterFile {
  public:
    GdalRaster(RasterHeader header, const LayerOptions& options, HandlePool& handles, GDALRasterBand& band,
               bool masked)
        : RasterFile(std::move(header), options), handles_(handles), band_(options.band), masked_(masked) {
        int tagged = 0;
        const double nodata = band.GetNoDataValue(&tagged);
        if (tagged != 0) add_nodata(nodata);
    }

  protected:
    void read_samples(const PixelWindow& window, void* samples) const override {
        read_band(window, samples, gdal_type(header().type), false);
    }

    void apply_mask(const PixelWindow& window, std::uint8_t* valid) const override {
        if (!masked_) return;
        std::vector<std::uint8_t> mask(static_cast<std::size_t>(window.width) *
                                       static_cast<std::size_t>(window.height));
        read_band(window, mask.data(), GDT_Byte, true);
        for (std::size_t i = 0; i < mask.size(); ++i)
            if (mask[i] == 0) valid[i] = 0;
    }

  private:
    void read_band(const PixelWindow& window, void* out, GDALDataType type, bool mask) const {
        HandlePool::Handle handle = handles_.acquire(header().path);
        const GdalErrors errors;
        GDALRasterBand* band = handle->GetRasterBand(band_);
        if (band == nullptr || handle->GetRasterXSize() != header().width ||
            handle->GetRasterYSize() != header().height)
            throw Error(ErrorCode::io, header().path + ": has changed while it was being read");
        if (mask) band = band->GetMaskBand();
        const CPLErr result =
            band->RasterIO(GF_Read, static_cast<int>(window.x), static_cast<int>(window.y), window.width,
                           window.height, out, window.width, window.height, type, 0, 0, nullptr);
        if (result != CE_None || errors.failed())
            throw Error(ErrorCode::io, header().path + ": cannot read samples: " + errors.text());
        handles_.release(header().path, std::move(handle));
    }

    HandlePool& handles_;
    int band_;
    bool masked_;
};

}  // namespace

void HandlePool::Closer::operator()(GDALDataset* d) const { GDALClose(d); }

HandlePool::Handle HandlePool::acquire(const std::string& path) {
    {
        const std::lock_guard lock(mutex_);
        for (auto it = idle_.begin(); it != idle_.end(); ++it)
            if (it->path == path) {
                Handle handle = std::move(it->handle);
                idle_.erase(it);
                return handle;
            }
    }
    initialise_gdal();
    const GdalErrors errors;
    Handle handle(GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR));
    if (!handle) throw Error(ErrorCode::io, path + ": cannot open: " + errors.text());
    return handle;
}

void HandlePool::release(const std::string& path, Handle handle) {
    std::list<Idle> surplus;  // closed after the lock is gone
    const std::lock_guard lock(mutex_);
    idle_.push_front({path, std::move(handle)});
    if (idle_.size() > kMaxIdle) surplus.splice(surplus.begin(), idle_, std::prev(idle_.end()));
}

std::unique_ptr<RasterFile> open_gdal_raster(const std::string& path, const LayerOptions& options,
                                             HandlePool& handles, std::vector<std::string>& warnings) {
    HandlePool::Handle handle = handles.acquire(path);
    const GdalErrors errors;
    GDALRasterBand& band = height_band(*handle, path, options.band);
    RasterHeader header;
    header.path = path;
    header.driver = handle->GetDriver() != nullptr ? handle->GetDriver()->GetDescription() : "";
    header.width = band.GetXSize();
    header.height = band.GetYSize();
    if (header.width < 1 || header.height < 1) throw Error(ErrorCode::unsupported, path + ": no samples");
    header.type = sample_type(band, path);
    band.GetBlockSize(&header.block_width, &header.block_height);
    read_scale(band, header, warnings);
    read_georeference(*handle, header);
    header.files = file_list(*handle);
    const int mask_flags = band.GetMaskFlags();
    const bool masked = (mask_flags & (GMF_ALL_VALID | GMF_NODATA)) == 0;
    header.may_have_holes = masked;
    auto raster = std::make_unique<GdalRaster>(std::move(header), options, handles, band, masked);
    handles.release(path, std::move(handle));
    return raster;
}

}  // namespace carat
