// Where a repository's bytes come from. Thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace carat {

class ByteSource {
  public:
    virtual ~ByteSource() = default;
    // For messages: the file's name.
    virtual const std::string& name() const = 0;
    virtual std::uint64_t size() const = 0;
    // Reads exactly out.size() bytes at offset. Throws Error(truncated) past the end, Error(io) if reading
    // fails.
    virtual void read(std::uint64_t offset, std::span<std::byte> out) const = 0;
};

// A local file, read with pread: a file cut short while open is an error, not a signal. Throws Error(io).
std::unique_ptr<ByteSource> open_file(const std::filesystem::path& path);
// Bytes in memory.
std::unique_ptr<ByteSource> bytes_in_memory(std::vector<std::byte> bytes, std::string name);

}  // namespace carat
