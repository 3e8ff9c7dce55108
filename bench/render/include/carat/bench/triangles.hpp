// How many triangles a picture needs: those of the stored bound, of an oracle that knows every sample of the
// file and the view, and of metrics that know nothing of the relief, at equal error as measured.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/globe/sphere.hpp"

namespace carat::bench {

struct TrianglesOptions {
    double threshold = 1;  // pixels
    int views = 16;
    unsigned seed = 1;
    int width = 1280, height = 720;
    std::optional<Geodetic> place;  // half of the views are near it
    // Told how many views are done; false: stop. May be empty.
    std::function<bool(std::size_t done, std::size_t total)> progress;
};

// A metric that refines while samples are further apart on the screen than a limit.
struct SpacingCut {
    double limit = 0;             // pixels
    std::uint64_t triangles = 0;  // 0: more than a million patches, and still not that exact
    double error = 0;             // pixels, as measured
};

struct TrianglesRow {
    std::string view;
    std::uint64_t ours = 0;      // triangles by the stored bound
    double error = 0;            // pixels: greatest error of what we draw, as measured
    std::uint64_t distance = 0;  // (c) the least cut whose distance from S nowhere projects to more
    std::uint64_t shift = 0;     // (c) the least one whose points are nowhere shifted more on the screen
    // Between ours and (c): the bound by the exact distance of each patch, whatever the view, and by those of
    // its quarters. A file could say these.
    std::uint64_t exact_delta = 0, exact_quarters = 0;
    SpacingCut paper_plain;      // (a) one triangle a pixel
    SpacingCut paper, nearness;  // (a) and (b) at our measured error
};

// Errors are measured at all vertices of the file's leaves that are on the screen and before the horizon,
// against the point of the flat patch at the same place of the lattice. Throws what the repository throws.
std::vector<TrianglesRow> measure_triangles(const std::shared_ptr<const Repository>& file,
                                            const TrianglesOptions& options);

}  // namespace carat::bench
