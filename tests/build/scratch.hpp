// A folder that a test writes in, and small builds there.
#pragma once

#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>
#include <span>
#include <string>
#include <vector>

#include "carat/preprocess/build.hpp"
#include "carat/synth/synth.hpp"

namespace carat::test {

struct Scratch {
    Scratch()
        : folder(std::filesystem::temp_directory_path() /
                 ("carat-build-" + std::to_string(std::random_device{}()))) {
        std::filesystem::create_directories(folder);
    }
    ~Scratch() { std::filesystem::remove_all(folder); }
    Scratch(const Scratch&) = delete;
    Scratch& operator=(const Scratch&) = delete;

    std::filesystem::path folder;
};

// Writes a kind's files into `folder` and makes each readable one a layer, in layer order.
inline BuildOptions synthetic_build(synth::Kind kind, const std::filesystem::path& folder, int size = 0) {
    synth::Options options;
    options.size = size;
    options.inset_size = size == 0 ? 0 : 64;
    BuildOptions build;
    for (const synth::Written& w : synth::write(kind, folder, options))
        build.layers.push_back({{(folder / w.name).string()}});
    build.body = synth::planet(kind, options).body;
    build.tolerance = 5;
    build.output = folder / "planet.carat";
    return build;
}

inline double height_at_point(const SourceStack& sources, const LatticePoint& point) {
    double height = 0;
    sources.sample(std::span(&point, 1), std::span(&height, 1));
    return height;
}

inline std::string bytes_of(const std::filesystem::path& file) {
    std::ifstream in(file, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
}

}  // namespace carat::test
