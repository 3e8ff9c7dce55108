// The fixed header of a repository file and its directory records: docs/format.md, "Header" and "Directory".
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "bytes.hpp"
#include "carat/codec/coding.hpp"
#include "carat/codec/repository.hpp"
#include "carat/codec/summary.hpp"
#include "page_layout.hpp"

namespace carat {

inline constexpr std::array<std::uint8_t, 8> kMagic{0x8A, 'C', 'A', 'R', 'A', 'T', 0x0D, 0x0A};
inline constexpr std::uint32_t kFormatVersion = 4;
inline constexpr std::size_t kFixedHeaderBytes = 152;
inline constexpr std::uint32_t kMaxHeaderBytes = 1u << 24;
inline constexpr std::uint32_t kMaxPartBytes = 64u << 10;         // pages above this are split
inline constexpr std::uint32_t kMaxSinglePartBytes = 1u << 20;    // no part is longer, whatever its diamonds
inline constexpr double kLeastAxis = 1e-3, kGreatestAxis = 1e12;  // equatorial semi-axis, metres
inline constexpr double kMostOblate = 10;                         // equatorial over polar semi-axis
inline constexpr std::uint32_t kDirectoryBlockEntries = 1024;

// A stretch of the file with its checksum (XXH3, 64 bits, seed 0).
struct Extent {
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
    std::uint64_t checksum = 0;
};

struct FileHeader {
    RepositoryHeader info;
    Coding coding;                  // orders: all, a reader does not know them
    std::vector<std::byte> tables;  // of the range coder; empty: built in
    std::uint64_t file_bytes = 0;
    Extent roots, directory;
    std::vector<std::int32_t> radii;

    SummaryGrid grid() const { return {info.body_a, info.quantum, info.log2_cells}; }
    std::vector<std::byte> to_bytes() const;
};

// Length of a header from its first 16 bytes. Throws Error(corrupt|unsupported|limit).
std::uint32_t parse_header_length(std::span<const std::byte> first16, const std::string& file);
// All of it, checksum and every value checked.
FileHeader parse_header(std::span<const std::byte> bytes, const std::string& file, std::uint64_t file_bytes);

// A part of a page: `slots` slots from first_slot on.
struct PartEntry {
    PageKey key = 0;
    std::uint64_t offset = 0;
    std::uint32_t bytes = 0;
    std::uint16_t first_slot = 0;
};
inline constexpr std::size_t kPartEntryBytes = 24;

// One block of the directory's second level.
struct BlockEntry {
    PageKey first_key = 0;
    std::uint16_t first_slot = 0;
    std::uint32_t entries = 0;
    std::uint64_t offset = 0;
    std::uint64_t checksum = 0;
};
inline constexpr std::size_t kBlockEntryBytes = 32;

std::uint64_t checksum_of(std::span<const std::byte> bytes);

void put(std::vector<std::byte>& out, const PartEntry& e);
void put(std::vector<std::byte>& out, const BlockEntry& e);
PartEntry get_part_entry(ByteParser& in);
BlockEntry get_block_entry(ByteParser& in);

}  // namespace carat
