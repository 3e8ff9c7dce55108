#include "render_stats.hpp"

#include <fmt/core.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "carat/globe/error.hpp"
#include "text.hpp"

namespace carat::cli {

namespace {

using Json = nlohmann::ordered_json;

// Body frame (globe/globe.hpp), metres.
Json camera_json(const Camera& c, double unit) {
    return {
        {"eye_m", to_metres(c.eye, unit)},    {"right", c.right}, {"up", c.up},        {"forward", c.forward},
        {"vertical_fov_rad", c.vertical_fov}, {"width", c.width}, {"height", c.height}};
}

}  // namespace

std::string RenderStats::summary() const {
    return fmt::format("{} patches, {} triangles, {} diamonds ({} decoded, {} virtual), {} read, {} on {}",
                       grouped(cut.patches), grouped(frame.triangles), grouped(cut.refined),
                       grouped(cut.decoded), grouped(cut.virtual_refined), bytes_text(cut.read.bytes),
                       duration(seconds), device);
}

void RenderStats::write(const std::string& path) const {
    const Json json = {
        {"device", device},
        {"camera", camera_json(camera, unit)},
        {"seconds", seconds},
        {"worst_error_px", std::isfinite(cut.worst_error) ? Json(cut.worst_error) : Json(nullptr)},
        {"read",
         {{"pages", cut.read.pages},
          {"bytes", cut.read.bytes},
          {"share_of_file", static_cast<double>(cut.read.bytes) / static_cast<double>(file_bytes)}}},
        {"diamonds",
         {{"refined", cut.refined},
          {"decoded", cut.read.diamonds_decoded},
          {"predicted", cut.read.diamonds_zero},
          {"virtual", cut.virtual_refined}}},
        {"halves",
         {{"tested", cut.halves_tested},
          {"culled_frustum", cut.culled_frustum},
          {"culled_horizon", cut.culled_horizon},
          {"limited", cut.limited}}},
        {"patches",
         {{"selected", cut.patches},
          {"uploaded", frame.patches_uploaded},
          {"drawn", frame.patches_drawn},
          {"culled_back", frame.patches_back},
          {"bytes_uploaded", frame.bytes_uploaded},
          {"batches", frame.batches},
          {"draw_calls", frame.draw_calls}}},
        {"triangles", frame.triangles},
        {"samples", frame.samples},
        {"shadows", {{"views", shadows.views}, {"triangles", shadows.triangles}}},
        {"milliseconds",
         {{"selection", cut.selection_ms},
          {"decode", cut.decode_ms},
          {"build", cut.build_ms},
          {"shadows", shadows.milliseconds},
          {"sky_tables", frame.table_ms},
          {"upload", frame.upload_ms},
          {"gpu", frame.gpu_ms},
          {"readback", frame.readback_ms}}}};
    std::ofstream out(path);
    out << json.dump(2) << '\n';
    if (!out.flush()) throw Error(ErrorCode::io, path + ": cannot be written");
}

}  // namespace carat::cli
