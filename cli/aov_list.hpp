// Which pictures a render is asked for, and how they become one.
#pragma once

#include <array>
#include <string>

#include "carat/globe/ellipsoid.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/vulkan/renderer.hpp"
#include "carat/vulkan/seen_points.hpp"

namespace carat::cli {

// Whether a picture written under this name is linear and without bound.
bool is_exr(const std::string& path);

// What was drawn: the numbers behind the pixels.
struct Scene {
    const DrawList& list;
    const Camera& camera;
    const Ellipsoid& body;
    double unit = 0;  // metres, of the camera's eye
    int cells = 64;   // of the meshes
};

class AovList {
  public:
    // Names separated by commas: color, depth, normal, position, height, latlon, error, level, source. Throws
    // Error(usage).
    static AovList parse(const std::string& text);

    // Throws Error(usage) if the file's format cannot hold them.
    void check_output(const std::string& path) const;
    Aovs wanted() const;
    // All channels in one picture, to be written to `path`, with the camera in its attributes; see the help
    // of carat render.
    Picture assemble(const Frame& frame, const Scene& scene, const std::string& path) const;

  private:
    enum Kind { color, depth, normal, position, height, latlon, error, level, source, kinds };
    static constexpr std::array<const char*, kinds> kNames{"color",  "depth", "normal", "position", "height",
                                                           "latlon", "error", "level",  "source"};
    bool has(Kind kind) const { return wanted_[kind]; }
    // Whether any is computed from the points seen.
    bool has_points() const { return has(depth) || has(position) || has(height) || has(latlon); }

    std::array<bool, kinds> wanted_{true};
};

}  // namespace carat::cli
