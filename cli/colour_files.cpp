#include "colour_files.hpp"

#include <fmt/core.h>
#include <tbb/parallel_for.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>

#include "carat/globe/bounds.hpp"
#include "text.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kPlanes{"Y", "Co", "Cg"};

Json provenance_of(const RepositoryHeader& h) {
    Json json = Json::parse(h.provenance, nullptr, false);
    return json.is_discarded() ? Json(h.provenance) : json;
}

std::uint64_t source_pixels(const Json& provenance) {
    return provenance.is_object() ? provenance.value("source_samples", std::uint64_t{0}) : 0;
}

Json plane_json(const RepositoryHeader& h, const FileCensus* census) {
    Json out{{"tolerance", h.tolerance - 0.5}, {"minimum", h.min_height}, {"maximum", h.max_height}};
    if (census == nullptr) return out;
    out["bytes"] = census->file_bytes;
    out["residual_bytes"] = census->coded_bytes;
    out["zero_diamonds"] = census->zero;
    return out;
}

double bits_a_pixel(std::uint64_t bytes, std::uint64_t pixels) {
    return pixels == 0 ? 0 : 8 * static_cast<double>(bytes) / static_cast<double>(pixels);
}

}  // namespace

void print_colour_info(const std::string& file, bool json, bool header_only) {
    const auto colour = ColourRepository::open(file);
    const RepositoryHeader& h = colour->header();
    const Json provenance = provenance_of(h);
    const std::uint64_t pixels = source_pixels(provenance);
    const double spacing = h.deepest_level == 0 ? 0
                                                : sample_spacing(h.ellipsoid(), root_diamond(0), h.cells()) /
                                                      std::exp2(h.deepest_level / 2.0);
    auto sources = open_colour_planes(file);
    std::array<FileCensus, kColourPlanes> census;
    if (!header_only)
        for (std::size_t k = 0; k < kColourPlanes; ++k) census[k] = take_census(*sources[k]);
    if (json) {
        Json planes;
        for (std::size_t k = 0; k < kColourPlanes; ++k)
            planes[kPlanes[k]] = plane_json(colour->plane(k).header(), header_only ? nullptr : &census[k]);
        const Json out{{"file", file},
                       {"attribute", "colour"},
                       {"format_version", h.format_version},
                       {"tolerance", colour->tolerance()},
                       {"planes", planes},
                       {"body", {{"name", h.body}, {"a_m", h.body_a}, {"b_m", h.body_b}}},
                       {"coder", h.coder},
                       {"n", h.n()},
                       {"deepest_level", h.deepest_level},
                       {"finest_spacing_m", spacing},
                       {"refined_diamonds", h.refined_diamonds},
                       {"bytes", {{"file", colour->file_bytes()}}},
                       {"source_pixels", pixels},
                       {"bits_per_source_pixel", bits_a_pixel(colour->file_bytes(), pixels)},
                       {"provenance", provenance}};
        fmt::print("{}\n", out.dump(2));
        return;
    }
    fmt::print("{:<16} {} ({} bytes, {})\n", "file", file, grouped(colour->file_bytes()),
               bytes_text(colour->file_bytes()));
    fmt::print("{:<16} colour: 8-bit sRGB in planes Y, Co, Cg, each a file of version {}\n", "attribute",
               h.format_version);
    fmt::print("{:<16} {} of 255 in every channel, at every sample of the file, at every level\n",
               "tolerance", colour->tolerance());
    fmt::print("{:<16} {}\n", "body", h.body.empty() ? "given" : h.body);
    fmt::print("{:<16} level {}, finest samples about {} apart\n", "depth", h.deepest_level,
               length_text(spacing));
    fmt::print("{:<16} {} diamonds\n", "refined", grouped(h.refined_diamonds));
    if (pixels > 0)
        fmt::print("{:<16} {:.4g} bits a source pixel ({} pixels)\n", "density",
                   bits_a_pixel(colour->file_bytes(), pixels), grouped(pixels));
    for (std::size_t k = 0; !header_only && k < kColourPlanes; ++k)
        fmt::print("{:<16} tolerance {}, {} bytes, residuals {}\n", std::string("plane ") + kPlanes[k],
                   number(colour->plane(k).header().tolerance - 0.5), grouped(census[k].file_bytes),
                   grouped(census[k].coded_bytes));
    if (!provenance.empty()) fmt::print("\nprovenance {}\n", provenance.dump(2));
}

bool verify_colour(const std::string& file, const VerifyOptions& options, bool json) {
    bool ok = true;
    Json planes;
    for (std::size_t k = 0; k < kColourPlanes; ++k) {
        const VerifyReport r = verify_source([&] { return std::move(open_colour_planes(file)[k]); }, options);
        ok = ok && r.ok();
        planes[kPlanes[k]] = {{"ok", r.ok()},
                              {"damage", r.damage},
                              {"damage_count", r.damage_count},
                              {"decoded", r.decoded},
                              {"pages", r.census.pages}};
        if (json) continue;
        for (const std::string& damage : r.damage) fmt::print("{}\n", damage);
        if (r.ok())
            fmt::print("{}, plane {}: ok: {} bytes, {} pages, {} diamonds decoded ({})\n", file, kPlanes[k],
                       grouped(r.census.file_bytes), grouped(r.census.pages), grouped(r.decoded),
                       duration(r.seconds));
        else
            fmt::print("{}, plane {}: damaged: {} findings\n", file, kPlanes[k], grouped(r.damage_count));
    }
    ColourRepository::open(file);  // do the planes fit together?
    if (json) fmt::print("{}\n", Json{{"file", file}, {"ok", ok}, {"planes", planes}}.dump(2));
    return ok;
}

void print_colours(const ColourRepository& file, const Points& points, bool json, bool first) {
    std::vector<ColourRepository::Sample> samples(points.size());
    tbb::parallel_for(std::size_t{0}, points.size(), [&](std::size_t k) {
        samples[k] = file.sample(lattice_position(direction(points.places[k])));
    });
    for (std::size_t k = 0; k < points.size(); ++k) {
        const ColourRepository::Sample& s = samples[k];
        if (!json) {
            fmt::print("{},{},{},{},{:.6g},{},measured\n", points.written(k), s.rgb[0], s.rgb[1], s.rgb[2],
                       s.spacing, s.at_lattice ? std::to_string(file.tolerance()) : "");
            continue;
        }
        const Json point = {{"lat", points.places[k].latitude},
                            {"lon", points.places[k].longitude},
                            {"rgb", s.rgb},
                            {"spacing_m", s.spacing},
                            {"bound", s.at_lattice ? Json(file.tolerance()) : Json(nullptr)},
                            {"measured", true}};
        fmt::print("{}\n    {}", first && k == 0 ? "" : ",", point.dump());
    }
}

void print_colour_report(const ColourBuildReport& report, const ColourBuildOptions& options, bool json) {
    const std::uint64_t pixels = report.planes[0].plan.source_samples;
    if (json) {
        Json planes;
        for (std::size_t k = 0; k < kColourPlanes; ++k)
            planes[kPlanes[k]] = {{"bytes", report.planes[k].file_bytes},
                                  {"max_error", report.planes[k].max_error},
                                  {"rms_error", report.planes[k].rms_error},
                                  {"seconds", report.planes[k].seconds}};
        fmt::print("{}\n", Json{{"file", options.build.output.string()},
                                {"tolerance", options.tolerance},
                                {"planes", planes},
                                {"bytes", {{"file", report.file_bytes}}},
                                {"source_pixels", pixels},
                                {"bits_per_source_pixel", bits_a_pixel(report.file_bytes, pixels)},
                                {"diamonds", report.planes[0].plan.refined},
                                {"seconds", report.seconds}}
                               .dump(2));
        return;
    }
    fmt::print("{}: {} bytes ({}) for {} pixels, {:.4g} bits each, {} diamonds, in {}\n",
               options.build.output.string(), grouped(report.file_bytes), bytes_text(report.file_bytes),
               grouped(pixels), bits_a_pixel(report.file_bytes, pixels),
               grouped(report.planes[0].plan.refined), duration(report.seconds));
    for (std::size_t k = 0; k < kColourPlanes; ++k)
        fmt::print("plane {:<2} {:>14} bytes, greatest error at samples {:.3g}, RMS {:.3g}\n", kPlanes[k],
                   grouped(report.planes[k].file_bytes), report.planes[k].max_error,
                   report.planes[k].rms_error);
}

}  // namespace carat::cli
