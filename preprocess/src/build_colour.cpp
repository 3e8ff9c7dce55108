#include "carat/preprocess/build_colour.hpp"

#include <chrono>

#include "carat/codec/colour.hpp"
#include "carat/globe/error.hpp"

namespace carat {
namespace {

namespace fs = std::filesystem;

// Where a plane lies until the planes are joined.
fs::path plane_path(const fs::path& output, std::size_t plane) {
    constexpr std::array suffixes{".Y", ".Co", ".Cg"};
    fs::path out = output;
    out += suffixes[plane];
    return out;
}

void check(const ColourBuildOptions& o) {
    if (o.tolerance < 0 || o.tolerance > 255)
        throw Error(ErrorCode::usage, "the tolerance of colours must be from 0 to 255");
    for (const LayerOptions& layer : o.build.layers)
        if (!layer.geoid.empty() || layer.valid_range)
            throw Error(ErrorCode::usage,
                        layer.files.front() + ": geoids and ranges of heights are not for colours");
    if (!o.build.overwrite && fs::exists(o.build.output))
        throw Error(ErrorCode::usage, o.build.output.string() + ": exists already; --overwrite replaces it");
}

BuildOptions plane_options(const ColourBuildOptions& o, std::size_t plane) {
    const ColourTolerances t = split_tolerance(o.tolerance);
    BuildOptions build = o.build;
    build.output = plane_path(o.build.output, plane);
    build.overwrite = true;
    build.quantum = 1;
    // Half a step more: heights between whole ones count as rounded.
    build.tolerance = (plane == 0 ? t.y : plane == 1 ? t.co : t.cg) + 0.5;
    build.vertical_datum = "unstated";
    build.base_height = ycocg_of_rgb({o.base_colour[0], o.base_colour[1], o.base_colour[2]})[plane];
    build.certify.reset();
    build.rms.reset();
    build.measure = false;
    for (LayerOptions& layer : build.layers) layer.colour_component = static_cast<int>(plane);
    return build;
}

}  // namespace

ColourBuildReport build_colour(const ColourBuildOptions& options, const ProgressFunction& progress) {
    const auto begin = std::chrono::steady_clock::now();
    check(options);
    ColourBuildReport report;
    std::array<fs::path, kColourPlanes> planes;
    for (std::size_t k = 0; k < kColourPlanes; ++k) planes[k] = plane_path(options.build.output, k);
    const auto remove = [&] {
        std::error_code ignored;
        for (const fs::path& plane : planes) fs::remove(plane, ignored);
    };
    try {
        for (std::size_t k = 0; k < kColourPlanes; ++k)
            report.planes[k] = build_repository(plane_options(options, k), progress);
        write_colour_file(options.build.output, planes, options.tolerance);
    } catch (...) {
        remove();
        throw;
    }
    remove();
    report.file_bytes = fs::file_size(options.build.output);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
}

}  // namespace carat
