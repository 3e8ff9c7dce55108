// manifest.json: what a directory of synthetic rasters holds, without times, hosts or paths.
#pragma once

#include <filesystem>
#include <vector>

#include "carat/synth/synth.hpp"

namespace carat::synth {

inline constexpr const char* kManifestName = "manifest.json";

/// Writes the manifest under a temporary name and renames it. Throws Error(io).
void write_manifest(Kind kind, const Options& options, const std::vector<Written>& files,
                    const std::filesystem::path& directory);

}  // namespace carat::synth
