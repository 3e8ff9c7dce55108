#include "carat/bench/globe_job.hpp"

#include <gdal_priv.h>
#include <gdal_utils.h>
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "carat/codec/verify.hpp"
#include "carat/globe/error.hpp"

namespace carat::bench {
namespace {

// A folder of its own that goes away.
class Scratch {
  public:
    Scratch()
        : path_(std::filesystem::temp_directory_path() / ("carat_bench_" + std::to_string(::getpid()))) {
        std::filesystem::create_directories(path_);
    }
    ~Scratch() {
        std::error_code ignored;
        std::filesystem::remove_all(path_, ignored);
    }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;
    std::string file(const char* name) const { return (path_ / name).string(); }

  private:
    std::filesystem::path path_;
};

// A view of a part of a raster, as a file.
void write_crop(const std::string& file, const Crop& c, const std::string& vrt) {
    GDALAllRegister();
    const std::string source = std::filesystem::absolute(file).string();
    GDALDatasetH in = GDALOpen(source.c_str(), GA_ReadOnly);
    if (in == nullptr) throw Error(ErrorCode::io, file + ": " + CPLGetLastErrorMsg());
    const std::string numbers[] = {std::to_string(c.x), std::to_string(c.y), std::to_string(c.width),
                                   std::to_string(c.height)};
    char* words[] = {const_cast<char*>("-of"),
                     const_cast<char*>("VRT"),
                     const_cast<char*>("-srcwin"),
                     const_cast<char*>(numbers[0].c_str()),
                     const_cast<char*>(numbers[1].c_str()),
                     const_cast<char*>(numbers[2].c_str()),
                     const_cast<char*>(numbers[3].c_str()),
                     nullptr};
    GDALTranslateOptions* options = GDALTranslateOptionsNew(words, nullptr);
    GDALDatasetH out = GDALTranslate(vrt.c_str(), in, options, nullptr);
    GDALTranslateOptionsFree(options);
    const bool written = out != nullptr;
    if (written) GDALClose(out);  // before its source
    GDALClose(in);
    if (!written) throw Error(ErrorCode::io, vrt + ": " + CPLGetLastErrorMsg());
}

}  // namespace

const std::vector<std::string>& globe_coders() {
    static const std::vector<std::string> all = {"range", "gamma"};
    return all;
}

GlobeRow bench_globe(const std::string& file, const std::optional<Crop>& crop, const Ellipsoid& body,
                     const std::string& coder, double tolerance, const ProgressFunction& progress) {
    const Scratch scratch;
    LayerOptions layer;
    layer.files = {file};
    if (crop) {
        layer.files = {scratch.file("crop.vrt")};
        write_crop(file, *crop, layer.files[0]);
    }
    BuildOptions options;
    options.layers = {layer};
    options.tolerance = tolerance;
    options.body = body;
    options.threads = 1;
    options.output = scratch.file("globe.carat");
    if (coder != "gamma" && coder != "range")
        throw Error(ErrorCode::usage, "there is no coder '" + coder + "'");
    options.coding = coder == "gamma" ? Coding::gamma() : Coding{};
    const BuildReport r = build_repository(options, progress);
    GlobeRow row;
    row.coder = coder;
    row.tolerance = tolerance;
    row.file_bytes = r.file_bytes;
    row.source_samples = r.plan.source_samples;
    row.leaf_samples = r.plan.leaf_samples;
    row.bits_per_source_sample =
        8 * static_cast<double>(r.file_bytes) / static_cast<double>(r.plan.source_samples);
    const FileCensus census = take_census(options.output);
    row.diamonds = census.refined;
    row.index_bytes = census.index_bytes() + census.directory_bytes;
    row.at_lattice = {r.max_error, r.rms_error};
    if (r.errors) {
        row.at_source = {r.errors->all.max, r.errors->all.rms};
        row.p99_at_source = r.errors->all.p99;
    }
    for (const auto& [stage, seconds] : r.stage_seconds)
        if (stage != BuildStage::measuring) row.build_seconds += seconds;
    return row;
}

}  // namespace carat::bench
