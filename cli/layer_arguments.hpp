// The options of layers, whose order matters: those after a --layer apply to it.
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "carat/preprocess/layer.hpp"

namespace carat::cli {

class LayerArguments {
  public:
    // lead: the option that begins a layer, "--layer".
    explicit LayerArguments(std::string lead = "--layer") : lead_(std::move(lead)) {}

    // Adds the lead, which may be repeated, and returns it.
    CLI::Option* add_lead(CLI::App& app, const std::string& description, const char* group);
    // Adds the options of a layer: --geoid, --valid-range, --nodata, --bounds, --feather, --resampling,
    // --band,
    // --latitude.
    void add_options(CLI::App& app, const char* group);

    // What a layer is before its options are read.
    using Begin = std::function<LayerOptions(std::vector<std::string> files)>;
    // The layers, in the order of the command line. Throws Error(usage) for an option ahead of the first
    // layer, one that is given twice for a layer, or a malformed value.
    std::vector<LayerOptions> layers(const Begin& begin = plain) const;

  private:
    static LayerOptions plain(std::vector<std::string> files) { return {std::move(files)}; }
    CLI::Option* add(CLI::App& app, const std::string& name, const std::string& form,
                     const std::string& description, const char* group);

    std::string lead_;
    const CLI::App* app_ = nullptr;
    std::vector<std::pair<std::string, const CLI::Option*>> options_;
};

}  // namespace carat::cli
