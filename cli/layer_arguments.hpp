// The options of layers, whose order matters: those after a --layer apply to it.
#pragma once

#include <CLI/App.hpp>
#include <string>
#include <utility>
#include <vector>

#include "carat/preprocess/layer.hpp"

namespace carat::cli {

class LayerArguments {
  public:
    // Adds an option of one value that may be repeated. Names: --layer, --geoid, --valid-range, --nodata,
    // --bounds,
    // --resampling, --band, --latitude.
    CLI::Option* add(CLI::App& app, const std::string& name, const std::string& form,
                     const std::string& description, const char* group);

    // The layers, in the order of the command line. Throws Error(usage) for an option ahead of the first
    // --layer, one that is given twice for a layer, or a malformed value.
    std::vector<LayerOptions> layers() const;

  private:
    const CLI::App* app_ = nullptr;
    std::vector<std::pair<std::string, const CLI::Option*>> options_;
};

}  // namespace carat::cli
