// Colour files: three builds, one a plane, joined (carat/codec/colour.hpp).
//
//   source   of a plane at a lattice point: the component of YCoCg-R of the layers' pixels, interpolated like
//   a height
//            and rounded; at the centre of a pixel the RGB of these is that pixel's
//   error    every channel of the file's RGB is within the tolerance of the RGB of these, at every lattice
//   point
#pragma once

#include "carat/preprocess/build.hpp"

namespace carat {

struct ColourBuildOptions {
    // Layers, body, mode, threads, memory, output and so on; tolerance, quantum, base height, certify and
    // measure are not used.
    BuildOptions build;
    int tolerance = 4;                                    // of 255, [0, 255]
    std::array<std::uint8_t, 3> base_colour{96, 96, 96};  // sRGB, where no layer has data
};

struct ColourBuildReport {
    std::array<BuildReport, 3> planes;
    std::uint64_t file_bytes = 0;
    double seconds = 0;
};

// Throws as build_repository() does.
ColourBuildReport build_colour(const ColourBuildOptions& options, const ProgressFunction& progress = {});

}  // namespace carat
