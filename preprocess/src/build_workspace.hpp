// Where a build keeps its temporary files, how much memory its parts may take, and what makes two builds the
// same.
#pragma once

#include <tbb/global_control.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "build_levels.hpp"
#include "carat/preprocess/build.hpp"
#include "step_store.hpp"

namespace carat {

// How a build's memory is shared out, bytes. What is left is for the program itself and the steps at work.
struct MemoryShares {
    std::size_t sources = 0;   // decoded source blocks
    std::size_t heights = 0;   // reconstructed heights
    std::size_t diamonds = 0;  // lists of diamonds
};
// Keeps the process to so many threads while it lives; 0: no limit.
std::optional<tbb::global_control> limit_threads(int threads);

// 0: a quarter of the machine's. Throws Error(usage) below kLeastMemory.
inline constexpr std::size_t kLeastMemory = std::size_t{256} << 20;
std::size_t memory_limit(const BuildOptions& options);
MemoryShares share_memory(std::size_t limit);
// Throws Error(limit) if the lists of diamonds do not fit.
void check_diamonds(std::uint64_t refined, std::size_t limit);

// Bytes of temporary files at their most: an upper bound, and what is usual.
struct TemporaryBytes {
    std::uint64_t bound = 0, usual = 0;
};
TemporaryBytes temporary_bytes(const RefinedLevels& levels, int n, Mode mode);

// OUT.carat.build beside the output, or in --temp with a mark of the output's path.
std::filesystem::path temporary_folder(const BuildOptions& options);

// The tolerance that an interrupted build with the same RMS error had come to, if this one is to resume it.
std::optional<double> tolerance_in_workspace(const BuildOptions& options);

// The store of a build. Compares the inputs and options with those that an earlier run left. Throws
// Error(usage) if resume is asked for and they differ, naming what; Error(io) if the disk has not enough
// room.
std::unique_ptr<StepStore> open_workspace(const BuildOptions& options, const SourceStack& sources,
                                          const TemporaryBytes& bytes);
// Everything that the bytes of the output depend on, as JSON.
std::string inputs_of(const BuildOptions& options, const SourceStack& sources);

// Peak resident memory of this process so far, bytes, as the operating system tells.
std::uint64_t peak_memory_bytes();

}  // namespace carat
