#include "pipeline_cache.hpp"

#include <cstdlib>
#include <filesystem>

#include "values.hpp"

namespace carat::cli {

std::string default_pipeline_cache() {
    const auto folder = [](const char* variable) {
        const char* const value = std::getenv(variable);
        return std::filesystem::path(value == nullptr ? "" : value);
    };
    // The XDG specification has relative paths ignored.
    if (const auto cache = folder("XDG_CACHE_HOME"); cache.is_absolute()) return (cache / "carat").string();
    if (const auto home = folder("HOME"); home.is_absolute()) return (home / ".cache" / "carat").string();
    return {};
}

CLI::Option* add_pipeline_cache(CLI::App& sub, std::string& folder) {
    folder = default_pipeline_cache();
    return add_value(sub, "--pipeline-cache", "DIR",
                     "Folder for compiled pipelines (default ~/.cache/carat); none: keep none",
                     [&folder](const std::string& text) { folder = text == "none" ? "" : text; });
}

}  // namespace carat::cli
