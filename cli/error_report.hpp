// Errors at source samples, for people and as JSON.
#pragma once

#include <nlohmann/json.hpp>

#include "carat/preprocess/measure.hpp"

namespace carat::cli {

// places: how many of the worst are printed for each layer.
void print_errors(const ErrorSummary& errors, std::size_t places);
nlohmann::ordered_json errors_json(const ErrorSummary& errors);

}  // namespace carat::cli
