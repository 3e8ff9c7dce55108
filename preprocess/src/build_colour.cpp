#include "carat/preprocess/build_colour.hpp"

#include <algorithm>
#include <chrono>
#include <fstream>
#include <iterator>

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

void refuse_to_replace(const ColourBuildOptions& o) {
    if (!o.build.overwrite && fs::exists(o.build.output))
        throw Error(ErrorCode::usage, o.build.output.string() + ": exists already; --overwrite replaces it");
}

void check(const ColourBuildOptions& o) {
    if (o.tolerance < 0 || o.tolerance > 255)
        throw Error(ErrorCode::usage, "the tolerance of colours must be from 0 to 255");
    for (const LayerOptions& layer : o.build.layers)
        if (!layer.geoid.empty() || layer.valid_range)
            throw Error(ErrorCode::usage,
                        layer.files.front() + ": geoids and ranges of heights are not for colours");
    if (!o.build.resume) refuse_to_replace(o);
}

BuildOptions plane_options(const ColourBuildOptions& o, std::size_t plane) {
    const ColourTolerances t = split_tolerance(o.tolerance);
    BuildOptions build = o.build;
    build.output = plane_path(o.build.output, plane);
    build.overwrite = !o.build.resume;  // planes that an interrupted build had finished are kept
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

using Planes = std::array<fs::path, kColourPlanes>;

void remove_planes(const Planes& planes) {
    std::error_code ignored;
    for (const fs::path& plane : planes) fs::remove(plane, ignored);
}

bool same_bytes(const fs::path& a, const fs::path& b) {
    using Bytes = std::istreambuf_iterator<char>;
    std::ifstream in_a(a, std::ios::binary), in_b(b, std::ios::binary);
    return fs::file_size(a) == fs::file_size(b) && std::equal(Bytes(in_a), Bytes(), Bytes(in_b));
}

// An output that is there already is right if it is what the planes make: its build was killed later.
void join_planes(const ColourBuildOptions& o, const Planes& planes) {
    if (o.build.overwrite || !fs::exists(o.build.output)) {
        write_colour_file(o.build.output, planes, o.tolerance);
        return;
    }
    fs::path again = o.build.output;
    again += ".again";
    write_colour_file(again, planes, o.tolerance);
    const bool same = same_bytes(again, o.build.output);
    fs::remove(again);
    if (same) return;
    remove_planes(planes);
    refuse_to_replace(o);
}

BuildReport build_plane(const ColourBuildOptions& o, std::size_t plane, const ProgressFunction& progress) {
    const BuildOptions build = plane_options(o, plane);
    try {
        return build_repository(build, progress);
    } catch (const Error& error) {
        if (error.code() != ErrorCode::usage || !build.resume || !fs::exists(build.output)) throw;
        throw Error(
            ErrorCode::usage,
            build.output.string() + ": is left of another build; without --resume this one starts anew");
    }
}

}  // namespace

ColourBuildReport build_colour(const ColourBuildOptions& options, const ProgressFunction& progress) {
    const auto begin = std::chrono::steady_clock::now();
    check(options);
    ColourBuildReport report;
    Planes planes;
    for (std::size_t k = 0; k < kColourPlanes; ++k) planes[k] = plane_path(options.build.output, k);
    bool cancelled = false;
    const auto watched = [&](const BuildProgress& p) {
        cancelled = progress && !progress(p);
        return !cancelled;
    };
    try {
        for (std::size_t k = 0; k < kColourPlanes; ++k) report.planes[k] = build_plane(options, k, watched);
        join_planes(options, planes);
    } catch (const Error& error) {
        // What --resume may go on with is kept, as the plane's own temporary files are.
        if (!cancelled && error.code() != ErrorCode::io && !options.build.resume) remove_planes(planes);
        throw;
    }
    remove_planes(planes);
    report.file_bytes = fs::file_size(options.build.output);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
}

}  // namespace carat
