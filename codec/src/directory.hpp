// The two-level page directory. Blocks are read when first needed. Thread-safe.
#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <optional>
#include <unordered_map>
#include <vector>

#include "carat/codec/byte_source.hpp"
#include "file_header.hpp"

namespace carat {

class Directory {
  public:
    // top: the bytes of the first level, checksum already checked. Throws Error(corrupt) for impossible
    // entries.
    Directory(const ByteSource& source, std::span<const std::byte> top);

    // The part of a page that should hold a slot: the one with the greatest first_slot <= slot.
    std::optional<PartEntry> find(PageKey key, int slot) const;
    // Every part, in the order of the file.
    std::vector<PartEntry> all() const;
    std::uint64_t bytes_read() const { return bytes_read_; }

  private:
    using Block = std::vector<PartEntry>;
    std::shared_ptr<const Block> block(std::size_t index) const;
    Block load(std::size_t index) const;

    const ByteSource& source_;
    std::vector<BlockEntry> blocks_;
    mutable std::mutex mutex_;
    mutable std::unordered_map<std::size_t, std::shared_ptr<const Block>> loaded_;
    mutable std::atomic<std::uint64_t> bytes_read_{0};
};

}  // namespace carat
