// The sources that a file is compared with: named one by one, or a folder where those that it records lie.
#pragma once

#include <string>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/preprocess/provenance.hpp"
#include "carat/preprocess/source.hpp"
#include "layer_arguments.hpp"

namespace carat::cli {

// Layers in the order given; options that are not given are those that the file records for a layer of the
// same first file. A single folder stands for all recorded layers. Throws Error(usage).
std::vector<LayerOptions> layers_against(const LayerArguments& arguments, const Provenance& recorded);

// Sentences on sources that differ from those recorded.
std::vector<std::string> differences(const SourceStack& sources, const Provenance& recorded);

}  // namespace carat::cli
