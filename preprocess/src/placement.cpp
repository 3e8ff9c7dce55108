#include "placement.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

constexpr std::int64_t kMaxJoined = std::int64_t{1}
                                    << 38;  // samples of a grid of several files, holes included

std::array<double, 6> transform_of(const std::array<double, 4>& bounds, const RasterHeader& header) {
    const auto [west, south, east, north] = bounds;
    if (!(std::abs(west) <= 360 && std::abs(east) <= 360 && south >= -90 && north <= 90 && south < north))
        throw Error(ErrorCode::usage, header.path + ": bounds must be west, south, east, north in degrees");
    const double span = east > west ? east - west : east - west + 360;
    if (!(span > 0 && span <= 360))
        throw Error(ErrorCode::usage, header.path + ": bounds wider than 360 degrees");
    return {west, span / header.width, 0, north, 0, -(north - south) / header.height};
}

bool looks_geographic(const std::array<double, 6>& g, const RasterHeader& header) {
    for (const double x : {0.0, static_cast<double>(header.width)})
        for (const double y : {0.0, static_cast<double>(header.height)}) {
            const double lon = g[0] + x * g[1] + y * g[2], lat = g[3] + x * g[4] + y * g[5];
            if (!(std::abs(lon) <= 361 && std::abs(lat) <= 91)) return false;
        }
    return true;
}

CrsBox box_of(const std::array<double, 6>& g, const RasterHeader& header) {
    CrsBox box{g[0], g[3], g[0], g[3]};
    for (const double x : {0.0, static_cast<double>(header.width)})
        for (const double y : {0.0, static_cast<double>(header.height)}) {
            const double east = g[0] + x * g[1] + y * g[2], north = g[3] + x * g[4] + y * g[5];
            box = {std::min(box.min_x, east), std::min(box.min_y, north), std::max(box.max_x, east),
                   std::max(box.max_y, north)};
        }
    return box;
}

CrsBox united(const CrsBox& a, const CrsBox& b) {
    return {std::min(a.min_x, b.min_x), std::min(a.min_y, b.min_y), std::max(a.max_x, b.max_x),
            std::max(a.max_y, b.max_y)};
}

// Offset of b in a's grid, in whole pixels; nothing if they share no grid.
std::optional<std::array<std::int64_t, 2>> offset_in(const GridPlan& plan, const PlacedFile& b) {
    constexpr double kTolerance = 0.01;  // pixels
    const std::array<double, 6>& g = plan.transform;
    const RasterHeader& ha = plan.parts.front().file->header();
    const RasterHeader& hb = b.file->header();
    if (plan.crs != b.crs || ha.type != hb.type || ha.scale != hb.scale || ha.offset != hb.offset)
        return std::nullopt;
    if (g[2] != 0 || g[4] != 0 || b.transform[2] != 0 || b.transform[4] != 0) return std::nullopt;
    const auto size = static_cast<double>(std::max(hb.width, hb.height));
    if (std::abs(g[1] - b.transform[1]) * size > kTolerance * std::abs(g[1]) ||
        std::abs(g[5] - b.transform[5]) * size > kTolerance * std::abs(g[5]))
        return std::nullopt;
    const double x = (b.transform[0] - g[0]) / g[1], y = (b.transform[3] - g[3]) / g[5];
    if (!(std::abs(x - std::round(x)) <= kTolerance && std::abs(y - std::round(y)) <= kTolerance) ||
        std::abs(x) > 1e9 || std::abs(y) > 1e9)
        return std::nullopt;
    return std::array{static_cast<std::int64_t>(std::round(x)), static_cast<std::int64_t>(std::round(y))};
}

// Adds b to the plan if it shares the grid and the whole stays within bounds.
bool joined(GridPlan& plan, const PlacedFile& b) {
    const auto offset = offset_in(plan, b);
    if (!offset) return false;
    const RasterHeader& h = b.file->header();
    const std::int64_t left = std::min<std::int64_t>(0, (*offset)[0]),
                       top = std::min<std::int64_t>(0, (*offset)[1]);
    const std::int64_t width = std::max(plan.width, (*offset)[0] + h.width) - left;
    const std::int64_t height = std::max(plan.height, (*offset)[1] + h.height) - top;
    const bool wider_than_globe =
        b.crs->turn() > 0 && static_cast<double>(width) * std::abs(plan.transform[1]) >
                                 b.crs->turn() + 2 * std::abs(plan.transform[1]);
    if (width * height > kMaxJoined || wider_than_globe) return false;
    for (GridPart& part : plan.parts) {
        part.x -= left;
        part.y -= top;
    }
    plan.transform[0] += static_cast<double>(left) * plan.transform[1];
    plan.transform[3] += static_cast<double>(top) * plan.transform[5];
    plan.width = width;
    plan.height = height;
    plan.parts.push_back({b.file, (*offset)[0] - left, (*offset)[1] - top});
    return true;
}

double wrapped(double lon) { return lon - 360 * std::floor((lon + 180) / 360); }

// West and east of the arc that contains all arcs, from the widest gap between them.
std::array<double, 2> united_longitudes(const std::vector<GeoBounds>& all) {
    struct Arc {
        double start, length;
    };
    std::vector<Arc> arcs;
    for (const GeoBounds& b : all) {
        const double length = b.east >= b.west ? b.east - b.west : b.east - b.west + 360;
        if (length >= 360 - 1e-9) return {-180, 180};
        arcs.push_back({wrapped(b.west), length});
    }
    std::sort(arcs.begin(), arcs.end(), [](const Arc& a, const Arc& b) { return a.start < b.start; });
    double reach = arcs.front().start, widest = -1, west = 0, east = 0;
    for (std::size_t i = 0; i < arcs.size(); ++i) {
        if (arcs[i].start - reach > widest && i > 0) {
            widest = arcs[i].start - reach;
            west = arcs[i].start;
            east = reach;
        }
        reach = std::max(reach, arcs[i].start + arcs[i].length);
    }
    if (arcs.front().start + 360 - reach > widest) {
        widest = arcs.front().start + 360 - reach;
        west = arcs.front().start;
        east = reach;
    }
    if (widest <= 1e-9) return {-180, 180};
    return {west, east > 180 ? east - 360 : east};
}

PlacedFile georeferenced(const RasterFile& file, const LayerOptions& options,
                         std::vector<std::string>& warnings) {
    const RasterHeader& h = file.header();
    if (options.bounds) {
        if (h.transform)
            throw Error(ErrorCode::usage,
                        h.path + ": has a georeference of its own; bounds are for images without");
        return {&file, "", Crs::plain(), transform_of(*options.bounds, h)};
    }
    if (!h.transform)
        throw Error(ErrorCode::usage,
                    h.path + ": has no georeference; give its bounds (west, south, east, north)");
    if (!h.wkt.empty()) return {&file, h.wkt, nullptr, *h.transform};
    if (!looks_geographic(*h.transform, h))
        throw Error(ErrorCode::usage, h.path +
                                          ": names no coordinate reference system, and its corners are no "
                                          "longitudes and latitudes");
    warnings.push_back(h.path +
                       ": names no coordinate reference system; taken as longitude and latitude in degrees");
    return {&file, "", Crs::plain(), *h.transform};
}

}  // namespace

std::vector<PlacedFile> place(const std::vector<std::unique_ptr<RasterFile>>& files,
                              const LayerOptions& options, const Ellipsoid& body,
                              std::vector<std::string>& warnings) {
    std::vector<PlacedFile> placed;
    std::map<std::string, CrsBox> boxes;
    for (const auto& file : files) {
        placed.push_back(georeferenced(*file, options, warnings));
        const CrsBox box = box_of(placed.back().transform, file->header());
        const auto [it, is_new] = boxes.try_emplace(placed.back().wkt, box);
        if (!is_new) it->second = united(it->second, box);
    }
    std::map<std::string, std::shared_ptr<const Crs>> systems;
    for (PlacedFile& p : placed) {
        if (p.crs) continue;
        std::shared_ptr<const Crs>& crs = systems[p.wkt];
        if (!crs)
            crs =
                Crs::of_wkt(p.wkt, boxes.at(p.wkt), body, options.latitude, p.file->header().path, warnings);
        p.crs = crs;
    }
    return placed;
}

std::vector<GridPlan> plan_grids(const std::vector<PlacedFile>& files) {
    std::vector<GridPlan> plans;
    for (const PlacedFile& f : files) {
        if (!plans.empty() && joined(plans.back(), f)) continue;
        const RasterHeader& h = f.file->header();
        plans.push_back({f.crs, f.transform, h.width, h.height, {{f.file, 0, 0}}});
    }
    return plans;
}

GeoBounds bounds_of(const Frame& frame) {
    constexpr int kSteps = 64;
    const auto w = static_cast<double>(frame.width()), h = static_cast<double>(frame.height());
    const auto centre = frame.normal(w / 2, h / 2);
    const double middle = centre ? geodetic(*centre).longitude : 0;
    GeoBounds b{360, 90, -360, -90};
    const auto add = [&](double u, double v) {
        const auto n = frame.normal(u, v);
        if (!n) return;
        const Geodetic g = geodetic(*n);
        const double lon = middle + wrapped(g.longitude - middle);
        b = {std::min(b.west, lon), std::min(b.south, g.latitude), std::max(b.east, lon),
             std::max(b.north, g.latitude)};
    };
    for (int i = 0; i <= kSteps; ++i) {
        const double t = static_cast<double>(i) / kSteps;
        for (const double side : {0.0, 1.0}) {
            add(t * w, side * h);
            add(side * w, t * h);
        }
    }
    for (const double pole : {-90.0, 90.0}) {
        double u = 0, v = 0;
        const double lon = 0;
        frame.to_pixels({&pole, 1}, {&lon, 1}, {&u, 1}, {&v, 1});
        if (!(u == u) || frame.crs().turn() > 0) continue;
        (pole < 0 ? b.south : b.north) = pole;
        b.west = middle - 180;
        b.east = middle + 180;
    }
    if (frame.rows_are_parallels()) {  // the sides exactly, and rasters wider than half the globe
        const double west = frame.transform()[0] + std::min(0.0, w * frame.transform()[1]);
        b.west = west * 360 / frame.crs().turn();
        b.east = b.west + w * std::abs(frame.transform()[1]) * 360 / frame.crs().turn();
    }
    if (frame.period() > 0 || b.east - b.west >= 360) return {-180, b.south, 180, b.north};
    if (b.east > 180 || b.west < -180) {
        b.west = wrapped(b.west);
        b.east = wrapped(b.east);
    }
    return b;
}

GeoBounds united(const std::vector<GeoBounds>& all) {
    if (all.empty()) return {};
    GeoBounds b = all.front();
    for (const GeoBounds& x : all) {
        b.south = std::min(b.south, x.south);
        b.north = std::max(b.north, x.north);
    }
    const auto [west, east] = united_longitudes(all);
    if (all.size() > 1) {
        b.west = west;
        b.east = east;
    }
    return b;
}

}  // namespace carat
