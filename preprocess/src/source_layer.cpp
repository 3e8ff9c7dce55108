#include "source_layer.hpp"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <filesystem>
#include <limits>

#include "blend.hpp"
#include "carat/globe/error.hpp"
#include "content_hash.hpp"
#include "placement.hpp"

namespace carat {
namespace {

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

// The feather of a grid in samples.
Feather feather_samples(const LayerOptions& options, const Frame& frame, const Ellipsoid& body,
                        const std::string& path, std::vector<std::string>& warnings) {
    constexpr double kHoles = 4, kLeastEdges = 16, kShareOfSide = 1.0 / 16, kMostOfSide = 1.0 / 4;
    const auto side = static_cast<double>(std::min(frame.width(), frame.height()));
    const double spacing =
        frame.spacing(body, static_cast<double>(frame.width()) / 2, static_cast<double>(frame.height()) / 2)
            .value_or(kInfinity);
    const auto given = [&](double metres, double most, const char* where) {
        if (!(metres >= 0)) throw Error(ErrorCode::usage, path + ": the feather is negative");
        if (metres / spacing <= most) return metres / spacing;
        warnings.push_back(path + ": the feather of " + std::to_string(metres) + " m at " + where +
                           " is cut to " + std::to_string(most * spacing) + " m, " + std::to_string(most) +
                           " samples");
        return most;
    };
    Feather out{kHoles, std::clamp(kShareOfSide * side, kLeastEdges, Grid::kMaxFeather)};
    if (options.feather) {
        out.holes = given(*options.feather, Grid::kMaxFeather, "holes");
        out.edges = out.holes;
    }
    if (options.feather_edges)
        out.edges = given(*options.feather_edges, std::max(1.0, kMostOfSide * side), "edges");
    return out;
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

void add_contents(std::vector<FileInfo>& infos, const std::vector<std::unique_ptr<RasterFile>>& files,
                  bool hash) {
    tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t i) {
        const std::vector<std::string>& names = files[i]->header().files;
        const ContentHash content = hash ? content_hash(names) : content_size(names);
        infos[i].hash = content.hash;
        infos[i].bytes = content.bytes;
    });
}

}  // namespace

double nominal_spacing(const LayerOptions& options, const Ellipsoid& body, HandlePool& handles) {
    std::vector<std::string> warnings;  // come again when the layer is made
    const auto files = open_files(options, handles, warnings);
    double spacing = kInfinity;
    for (const PlacedFile& placed : place(files, options, body, warnings))
        spacing = std::min(spacing, describe(placed, body).spacing);
    return spacing;
}

SourceLayer::SourceLayer(const LayerOptions& options, const Ellipsoid& body, HandlePool& handles,
                         TileCache& cache, std::uint64_t key, std::vector<std::string>& warnings,
                         const LayerOpening& opening)
    : resampling_(options.resampling), files_(open_files(options, handles, warnings)) {
    const std::vector<PlacedFile> placed = place(files_, options, body, warnings);
    for (const PlacedFile& p : placed)
        if (!options.geoid.empty() && Crs::has_ellipsoidal_heights(p.wkt))
            throw Error(ErrorCode::usage,
                        p.file->header().path +
                            ": its coordinate reference system says that its "
                            "heights are above the ellipsoid; a geoid would be added twice");
    std::vector<GeoBounds> bounds;
    for (const PlacedFile& p : placed) {
        info_.files.push_back(describe(p, body));
        info_.spacing = std::min(info_.spacing, info_.files.back().spacing);
        bounds.push_back(info_.files.back().bounds);
    }
    add_contents(info_.files, files_, opening.hash);
    info_.name = std::filesystem::path(options.files.front()).filename().string();
    info_.bounds = united(bounds);
    info_.geoid = options.geoid;

    std::vector<GridPlan> plans = plan_grids(placed);
    if (plans.size() >= kKeysPerLayer)
        throw Error(ErrorCode::limit, options.files.front() + ": its layer has " +
                                          std::to_string(plans.size()) + " separate grids, more than " +
                                          std::to_string(kKeysPerLayer - 1));
    for (GridPlan& plan : plans) {
        const std::string& path = plan.parts.front().file->header().path;
        Frame frame(plan.crs, plan.transform, plan.width, plan.height, path);
        const Feather feather = feather_samples(options, frame, body, path, warnings);
        grids_.push_back(std::make_unique<Grid>(std::move(frame), std::move(plan.parts), body, feather, cache,
                                                key + grids_.size(), opening.lazy));
        info_.samples += grids_.back()->samples();
        info_.valid_samples += grids_.back()->valid_samples();
    }
    if (!options.geoid.empty())
        geoid_ = Geoid::open(options.geoid, body, handles, cache, key + kKeysPerLayer / 2 + grids_.size(),
                             warnings);
}

// Every grid is asked for the places that no grid before it has closed.
void SourceLayer::sample_chunk(std::span<const double> lat, std::span<const double> lon, const Cap& cap,
                               std::span<double> heights, std::span<std::uint8_t> valid,
                               std::span<double> weights) const {
    std::size_t open = lat.size();
    Blend blend(open);
    std::array<std::size_t, kChunk> index;
    std::array<double, kChunk> open_lat, open_lon, found, weight;
    std::array<std::uint8_t, kChunk> there;
    std::copy(lat.begin(), lat.end(), open_lat.begin());
    std::copy(lon.begin(), lon.end(), open_lon.begin());
    for (std::size_t i = 0; i < open; ++i) index[i] = i;
    for (std::size_t g = 0; g < grids_.size() && open > 0; ++g) {
        const Grid& grid = *grids_[g];
        if (!meet(grid.cap(), cap)) continue;
        const std::span<const double> la(open_lat.data(), open), lo(open_lon.data(), open);
        const std::span<std::uint8_t> hit(there.data(), open);
        grid.sample(la, lo, resampling_, std::span(found).first(open), hit);
        const bool weighed = !weights.empty() || g + 1 < grids_.size();
        if (weighed) grid.weigh(la, lo, hit, std::span(weight).first(open));
        std::size_t left = 0;
        for (std::size_t i = 0; i < open; ++i) {
            if (hit[i] != 0) blend.add(index[i], found[i], weighed ? weight[i] : 1);
            if (blend.closed(index[i])) continue;
            index[left] = index[i];
            open_lat[left] = open_lat[i];
            open_lon[left++] = open_lon[i];
        }
        open = left;
    }
    for (std::size_t i = 0; i < lat.size(); ++i) {
        valid[i] = blend.any(i) ? 1 : 0;
        heights[i] = blend.any(i) ? blend.height(i) : 0;
        if (!weights.empty()) weights[i] = blend.weight(i);
    }
    if (geoid_) geoid_->add(lat, lon, heights, valid);
}

void SourceLayer::sample(std::span<const double> lat, std::span<const double> lon, const Cap& cap,
                         std::span<double> heights, std::span<std::uint8_t> valid,
                         std::span<double> weights) const {
    for (std::size_t start = 0; start < lat.size(); start += kChunk) {
        const std::size_t n = std::min(kChunk, lat.size() - start);
        const auto part = [&](auto span) { return span.empty() ? span : span.subspan(start, n); };
        sample_chunk(part(lat), part(lon), cap, part(heights), part(valid), part(weights));
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
