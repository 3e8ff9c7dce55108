// The benchmarks of `carat bench`: one function and one file each. Built with CARAT_BUILD_BENCH only.
#pragma once

#include <optional>
#include <string>

#include "carat/bench/raster.hpp"
#include "carat/render/view.hpp"
#include "commands.hpp"

namespace carat::cli {

void add_bench_codec(CLI::App& bench, Globals& globals);
void add_bench_build(CLI::App& bench, Globals& globals);
void add_bench_color(CLI::App& bench, Globals& globals);
void add_bench_summaries(CLI::App& bench, Globals& globals);
void add_bench_refine(CLI::App& bench, Globals& globals);
void add_bench_deadline(CLI::App& bench, Globals& globals);
void add_bench_scaling(CLI::App& bench, Globals& globals);
void add_bench_stability(CLI::App& bench, Globals& globals);
void add_bench_look(CLI::App& bench, Globals& globals);
void add_bench_shimmer(CLI::App& bench, Globals& globals);
void add_bench_detail(CLI::App& bench, Globals& globals);
void add_bench_watertight(CLI::App& bench, Globals& globals);
void add_bench_error(CLI::App& bench, Globals& globals);
void add_bench_triangles(CLI::App& bench, Globals& globals);
void add_bench_threshold(CLI::App& bench, Globals& globals);
void add_bench_frames(CLI::App& bench, Globals& globals);

// Does nothing without a name. Throws Error(io).
void write_text(const std::string& file, const std::string& text);

// Adds --heading, --pitch and --size, with what `view` holds as defaults.
void add_bench_direction(CLI::App& sub, ViewRequest& view);

// Adds --crop X,Y,W,H.
void add_crop(CLI::App& sub, std::optional<bench::Crop>& crop);

}  // namespace carat::cli
