#include "against.hpp"

#include <algorithm>
#include <filesystem>

#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

namespace fs = std::filesystem;

std::string name_of(const std::string& path) { return fs::path(path).filename().string(); }

const RecordedLayer* find(const Provenance& recorded, const std::string& first_file) {
    for (const RecordedLayer& layer : recorded.layers)
        if (!layer.files.empty() && layer.files.front().name == name_of(first_file)) return &layer;
    return nullptr;
}

LayerOptions begin_layer(std::vector<std::string> files, const Provenance& recorded) {
    LayerOptions out;
    if (const RecordedLayer* layer = find(recorded, files.front())) out = layer->options;
    if (!out.geoid.empty()) out.geoid = (fs::path(files.front()).parent_path() / out.geoid).string();
    out.files = std::move(files);
    return out;
}

std::vector<LayerOptions> layers_in(const fs::path& folder, const Provenance& recorded) {
    std::vector<LayerOptions> out;
    for (const RecordedLayer& layer : recorded.layers) {
        LayerOptions o = layer.options;
        for (std::string& file : o.files) file = (folder / file).string();
        if (!o.geoid.empty()) o.geoid = (folder / o.geoid).string();
        out.push_back(std::move(o));
    }
    if (out.empty())
        throw Error(ErrorCode::usage,
                    "--against " + folder.string() + ": the file records no sources; name them");
    return out;
}

}  // namespace

std::vector<LayerOptions> layers_against(const LayerArguments& arguments, const Provenance& recorded) {
    std::vector<LayerOptions> layers = arguments.layers(
        [&](std::vector<std::string> files) { return begin_layer(std::move(files), recorded); });
    if (layers.size() == 1 && layers.front().files.size() == 1 &&
        fs::is_directory(layers.front().files.front()))
        return layers_in(layers.front().files.front(), recorded);
    for (const LayerOptions& layer : layers)
        if (!layer.geoid.empty() && !fs::exists(layer.geoid))
            throw Error(ErrorCode::usage, layer.files.front() + ": was built with the geoid " +
                                              name_of(layer.geoid) +
                                              ", which does not lie beside it; give --geoid");
    return layers;
}

std::vector<std::string> differences(const SourceStack& sources, const Provenance& recorded) {
    std::vector<std::string> out;
    std::vector<RecordedFile> known;
    for (const RecordedLayer& layer : recorded.layers)
        known.insert(known.end(), layer.files.begin(), layer.files.end());
    std::size_t met = 0;
    for (const LayerInfo& layer : sources.layers())
        for (const FileInfo& file : layer.files) {
            const auto it = std::find_if(known.begin(), known.end(),
                                         [&](const RecordedFile& k) { return k.name == name_of(file.path); });
            if (it == known.end()) {
                out.push_back(file.path + ": is not among the sources that the file records");
                continue;
            }
            ++met;
            if (it->bytes != file.bytes || it->hash != file.hash)
                out.push_back(file.path +
                              ": differs from the source of that name that the file was built from");
        }
    if (met < known.size())
        out.push_back(
            "not all sources that the file records are given: samples that a missing layer hides are "
            "compared");
    return out;
}

}  // namespace carat::cli
