// Small planets in real files, views of all manners over them, and drawing them with every picture.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "build/scratch.hpp"
#include "carat/codec/repository.hpp"
#include "carat/render/refiner.hpp"
#include "carat/vulkan/renderer.hpp"

namespace carat::test {

inline constexpr int kFileLog2Cells = 4, kFileCells = 1 << kFileLog2Cells;
using MeshList = std::vector<std::shared_ptr<const PatchMesh>>;

struct FilePlanet {
    std::filesystem::path file;
    Geodetic detailed;  // where the finest layer is
};
// A synthetic planet of 17 x 17 diamonds, built into `folder`.
FilePlanet build_planet(synth::Kind kind, const std::filesystem::path& folder, double tolerance);

struct FileView {
    std::string name;
    View view;
    double threshold = 1;  // pixels: such that there are some hundred patches at most
};
// From orbit, at the limb, oblique, grazing and from the ground, over the detailed place, a pole and the
// antimeridian.
std::vector<FileView> file_views(const FilePlanet& planet, int width, int height);

// With every AOV, before magenta.
DrawRequest picture_request(const View& view);
// Bit for bit.
void expect_same_pictures(const Frame& a, const Frame& b, const std::string& what);

}  // namespace carat::test
