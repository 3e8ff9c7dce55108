#include "source_layer.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "carat/globe/error.hpp"
#include "content_hash.hpp"
#include "placement.hpp"

namespace carat {
namespace {

constexpr std::size_t kChunk = 512;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::vector<std::unique_ptr<RasterFile>> open_files(const LayerOptions& options, HandlePool& handles,
                                                    std::vector<std::string>& warnings) {
    if (options.files.empty()) throw Error(ErrorCode::usage, "a layer without files");
    if (options.valid_range && !((*options.valid_range)[0] <= (*options.valid_range)[1]))
        throw Error(ErrorCode::usage, options.files.front() + ": the valid range is empty");
    std::vector<std::unique_ptr<RasterFile>> files;
    for (const std::string& path : options.files)
        files.push_back(RasterFile::open(path, options, handles, warnings));
    return files;
}

FileInfo describe(const PlacedFile& placed, const Ellipsoid& body) {
    const RasterHeader& h = placed.file->header();
    const Frame frame(placed.crs, placed.transform, h.width, h.height, h.path);
    FileInfo info;
    info.path = h.path;
    info.driver = h.driver;
    info.crs = placed.wkt;
    info.width = h.width;
    info.height = h.height;
    info.bounds = bounds_of(frame);
    info.spacing = frame.spacing(body, h.width / 2.0, h.height / 2.0).value_or(kInfinity);
    info.transformation = placed.crs->transformation();
    return info;
}

void add_contents(std::vector<FileInfo>& infos, const std::vector<std::unique_ptr<RasterFile>>& files) {
    tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t i) {
        const ContentHash content = content_hash(files[i]->header().files);
        infos[i].hash = content.hash;
        infos[i].bytes = content.bytes;
    });
}

}  // namespace

SourceLayer::SourceLayer(const LayerOptions& options, const Ellipsoid& body, HandlePool& handles,
                         TileCache& cache, std::uint64_t key, std::vector<std::string>& warnings)
    : resampling_(options.resampling), files_(open_files(options, handles, warnings)) {
    const std::vector<PlacedFile> placed = place(files_, options, body, warnings);
    std::vector<GeoBounds> bounds;
    for (const PlacedFile& p : placed) {
        info_.files.push_back(describe(p, body));
        info_.spacing = std::min(info_.spacing, info_.files.back().spacing);
        bounds.push_back(info_.files.back().bounds);
    }
    add_contents(info_.files, files_);
    info_.name = std::filesystem::path(options.files.front()).filename().string();
    info_.bounds = united(bounds);
    info_.geoid = options.geoid;

    std::vector<GridPlan> plans = plan_grids(placed);
    if (plans.size() >= kKeysPerLayer)
        throw Error(ErrorCode::limit, options.files.front() + ": its layer has " +
                                          std::to_string(plans.size()) + " separate grids, more than " +
                                          std::to_string(kKeysPerLayer - 1));
    for (GridPlan& plan : plans) {
        Frame frame(plan.crs, plan.transform, plan.width, plan.height,
                    plan.parts.front().file->header().path);
        grids_.push_back(std::make_unique<Grid>(std::move(frame), std::move(plan.parts), body, cache,
                                                key + grids_.size()));
        info_.samples += grids_.back()->samples();
        info_.valid_samples += grids_.back()->valid_samples();
    }
    if (!options.geoid.empty())
        geoid_ = Geoid::open(options.geoid, body, handles, cache, key + kKeysPerLayer / 2 + grids_.size(),
                             warnings);
}

void SourceLayer::sample_grids(std::span<const double> lat, std::span<const double> lon, const Cap& cap,
                               std::span<double> heights, std::span<std::uint8_t> valid) const {
    std::fill(valid.begin(), valid.end(), std::uint8_t{0});
    std::size_t missing = lat.size();
    std::array<std::size_t, kChunk> index;
    std::array<double, kChunk> some_lat, some_lon, some_heights;
    std::array<std::uint8_t, kChunk> some_valid;
    for (const auto& grid : grids_) {
        if (missing == 0) return;
        if (!meet(grid->cap(), cap)) continue;
        if (missing == lat.size()) {  // the common case: nothing found yet
            grid->sample(lat, lon, resampling_, heights, valid);
        } else {
            std::size_t n = 0;
            for (std::size_t i = 0; i < lat.size(); ++i) {
                if (valid[i] != 0) continue;
                index[n] = i;
                some_lat[n] = lat[i];
                some_lon[n] = lon[i];
                ++n;
            }
            grid->sample(std::span(some_lat).first(n), std::span(some_lon).first(n), resampling_,
                         std::span(some_heights).first(n), std::span(some_valid).first(n));
            for (std::size_t k = 0; k < n; ++k) {
                if (some_valid[k] == 0) continue;
                heights[index[k]] = some_heights[k];
                valid[index[k]] = 1;
            }
        }
        missing = static_cast<std::size_t>(std::count(valid.begin(), valid.end(), std::uint8_t{0}));
    }
}

void SourceLayer::sample(std::span<const double> lat, std::span<const double> lon, const Cap& cap,
                         std::span<double> heights, std::span<std::uint8_t> valid) const {
    for (std::size_t start = 0; start < lat.size(); start += kChunk) {
        const std::size_t n = std::min(kChunk, lat.size() - start);
        const auto part = [&](auto span) { return span.subspan(start, n); };
        sample_grids(part(lat), part(lon), cap, part(heights), part(valid));
        if (geoid_) geoid_->add(part(lat), part(lon), part(heights), part(valid));
    }
}

bool SourceLayer::may_meet(const Cap& cap) const {
    return std::any_of(grids_.begin(), grids_.end(),
                       [&](const auto& grid) { return meet(grid->cap(), cap); });
}

Coverage SourceLayer::cover(std::span<const Vec3> places, const Cap& cap) const {
    Coverage result{kInfinity, false};
    for (const auto& grid : grids_) {
        if (!meet(grid->cap(), cap)) continue;
        const Coverage part = grid->cover(places, cap);
        result.spacing = std::min(result.spacing, part.spacing);
        result.full = result.full || part.full;
        if (part.full) break;  // hides the grids below
    }
    return result;
}

}  // namespace carat
