// Colour files in the subcommands that read .carat files.
#pragma once

#include <memory>
#include <string>

#include "carat/codec/colour.hpp"
#include "carat/codec/verify.hpp"
#include "carat/preprocess/build_colour.hpp"
#include "points.hpp"

namespace carat::cli {

// What `carat info` says. header_only: no pages are read.
void print_colour_info(const std::string& file, bool json, bool header_only);

// What `carat verify` says: every plane for itself. Returns whether all are sound.
bool verify_colour(const std::string& file, const VerifyOptions& options, bool json);

// Lines of `carat query`: lat,lon,red,green,blue,spacing_m,bound.
inline constexpr const char* kColourColumns = "lat,lon,red,green,blue,spacing_m,bound,measured";
void print_colours(const ColourRepository& file, const Points& points, bool json, bool first);

// The report of `carat build --color`.
void print_colour_report(const ColourBuildReport& report, const ColourBuildOptions& options, bool json);

}  // namespace carat::cli
