// Where compiled pipelines are kept between runs: an option that render and fly share.
#pragma once

#include <CLI/App.hpp>
#include <string>

namespace carat::cli {

// $XDG_CACHE_HOME/carat, else $HOME/.cache/carat, else "": none are kept.
std::string default_pipeline_cache();

// --pipeline-cache DIR; "none" keeps none. `folder` is a RendererOptions::pipeline_cache.
CLI::Option* add_pipeline_cache(CLI::App& sub, std::string& folder);

}  // namespace carat::cli
