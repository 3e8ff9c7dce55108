// What a file says of how it was made: JSON in its header, without times, hosts or folders.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "carat/preprocess/build.hpp"
#include "carat/preprocess/layer.hpp"
#include "carat/preprocess/measure.hpp"

namespace carat {

// Places of greatest error that are recorded for each layer.
inline constexpr std::size_t kRecordedPlaces = 5;

// The provenance of a build, with the errors at source samples if they have been measured, and the
// certificate if there is one.
std::string provenance_json(const BuildOptions& options, const BuildPlan& plan,
                            const ErrorSummary* errors = nullptr,
                            const std::optional<Certification>& certification = std::nullopt);
// True if what a file says of itself is what provenance_json() of this build says; shares and errors, known
// at the end only, aside, but for whether errors are recorded.
bool same_build(const std::string& recorded, const BuildOptions& options, const BuildPlan& plan,
                const std::optional<Certification>& certification);
// Bytes that hold the same provenance with any errors.
std::size_t measured_room(const std::string& provenance, const BuildPlan& plan);

// A source file as a repository names it.
struct RecordedFile {
    std::string name;  // without folder
    std::uint64_t bytes = 0, hash = 0;
};
// A layer as a repository names it.
struct RecordedLayer {
    LayerOptions options;  // names of files and geoid without their folders
    std::vector<RecordedFile> files;
    std::uint64_t geoid_hash = 0;  // XXH3 of the geoid's file, if there is one
};
struct Provenance {
    std::vector<RecordedLayer> layers;
    double base_height = 0;
    Mode mode = Mode::interpolating;
    unsigned orders = 0;  // of prediction that the encoder could choose among, Coding::orders
    double depth_bias = 0;
    int max_level = 0;
    std::uint64_t source_samples = 0;  // valid ones, of all layers
    std::optional<double> certify;     // what was asked for; certificate: what was reached
    std::vector<LayerShare> shares;    // of each layer, last of the base height; empty if not recorded
    std::optional<ErrorSummary> errors;
    // Metres: no compared source sample is further from S (measure.hpp).
    std::optional<double> certificate;
};
// Throws Error(corrupt) if it is not what provenance_json() writes.
Provenance parse_provenance(const std::string& json);

}  // namespace carat
