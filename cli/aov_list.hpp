// Which pictures a render is asked for, and how they become one.
#pragma once

#include <string>

#include "carat/vulkan/renderer.hpp"

namespace carat::cli {

// Whether a picture written under this name is linear and without bound.
bool is_exr(const std::string& path);

class AovList {
  public:
    // Names separated by commas: color, depth, normal, position, height, level. Throws Error(usage).
    static AovList parse(const std::string& text);

    // Throws Error(usage) if the file's format cannot hold them.
    void check_output(const std::string& path) const;
    Aovs wanted() const;
    // All channels in one picture, to be written to `path`; see the help of carat render.
    Picture assemble(const Frame& frame, const std::string& path) const;

  private:
    bool colour_ = true, depth_ = false, normal_ = false, position_ = false, height_ = false, level_ = false;
};

}  // namespace carat::cli
