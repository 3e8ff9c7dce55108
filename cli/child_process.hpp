// Programs run to their end, with what the operating system says they took.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace carat::cli {

struct ChildUsage {
    double seconds = 0;                   // by the wall clock
    double processor_seconds = 0;         // user and system, all threads
    std::uint64_t peak_memory_bytes = 0;  // resident
};

// Runs a program, found through PATH unless its name has a slash, with stdout and stderr in files. Throws
// Error(io): cannot be started, or ended with anything but 0 (what it wrote to stderr is in the message).
ChildUsage run_child(const std::vector<std::string>& arguments, const std::filesystem::path& out,
                     const std::filesystem::path& err);

}  // namespace carat::cli
