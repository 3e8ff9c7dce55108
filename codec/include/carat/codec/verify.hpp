// Looking at a whole file: what it holds, and whether all of it is sound.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/repository.hpp"

namespace carat {

// The refined diamonds of one level.
struct LevelCensus {
    std::uint64_t refined = 0;
    std::uint64_t zero = 0;                // of these, without residuals: decoded by prediction alone
    std::uint64_t coded_bytes = 0;         // of residuals
    std::array<std::uint64_t, 3> modes{};  // of those with residuals, by Mode
};

// What a file holds. Bytes: file_bytes = header + roots + pages + directory, and pages = index + coded.
struct FileCensus {
    std::vector<LevelCensus> levels;  // 0 to the deepest refined
    std::uint64_t refined = 0, zero = 0;
    std::uint64_t pages = 0;       // distinct
    std::uint64_t parts = 0;       // pages above 64 KiB are split
    std::uint64_t zero_pages = 0;  // of the pages, marks "all zero to level D"
    std::uint64_t file_bytes = 0, header_bytes = 0, root_bytes = 0, directory_bytes = 0, page_bytes = 0;
    std::uint64_t coded_bytes = 0;

    std::uint64_t index_bytes() const { return page_bytes - coded_bytes; }
};

// Reads every page of a file once and decodes nothing. Throws Error(corrupt|truncated|unsupported|limit|io)
// at the first damage.
FileCensus take_census(const std::filesystem::path& file);
FileCensus take_census(const ByteSource& source);

struct VerifyOptions {
    int threads = 0;                        // 0: all
    std::size_t memory_bytes = 256u << 20;  // for decoded diamonds
    std::size_t damage_limit = 100;         // of damages listed; all are counted
    // Diamonds decoded below a page that says of all of them that they are zero: such a page can stand for
    // 2^50, which all follow from the same heights by prediction.
    std::uint64_t zero_page_limit = 1u << 14;
    // Called from one thread at a time with the diamonds looked at; returning false throws Error(usage)
    // "cancelled".
    std::function<bool(std::uint64_t done, std::uint64_t total)> progress = {};
};

struct VerifyReport {
    std::vector<std::string> damage;  // plain sentences, in the order of the file; at most damage_limit
    std::uint64_t damage_count = 0;
    std::vector<std::string> remarks;  // odd, but no damage: gaps and overlaps between parts
    FileCensus census;                 // of what could be read
    std::uint64_t decoded = 0;         // refined diamonds decoded and found sound or damaged
    std::uint64_t unreachable = 0;     // not decoded, for damage in them or above
    std::uint64_t zero_skipped = 0;    // not decoded, beyond zero_page_limit
    std::uint64_t heights = 0;         // values compared with summaries
    std::uint64_t shared_heights = 0;  // vertices on longest edges compared between two parents
    double seconds = 0;

    bool ok() const { return damage_count == 0; }
};

// Checks the whole of a file:
//
//   bytes      header, root values, directory and every part of a page parse and fit their checksums;
//              pages hold diamonds of their own only, and nothing lies below a zero page
//   DAG        both parents of every refined diamond are refined; counts and depth agree with the header
//   heights    every refined diamond decodes (of those below a zero page the first zero_page_limit); the
//   halves that its two parents give it agree on their
//              common edge; all its heights lie within its summaries, those of all its ancestors, and the
//              header's range
//
// Time is bounded by the bytes of the file, memory stays near memory_bytes whatever the size of the file.
// Throws Error(io) if the file cannot be opened; every damage is a line of the report.
VerifyReport verify_file(const std::filesystem::path& file, const VerifyOptions& options = {});
// The same of bytes from elsewhere; `open` is called twice.
using OpenSource = std::function<std::unique_ptr<ByteSource>()>;
VerifyReport verify_source(const OpenSource& open, const VerifyOptions& options = {});

}  // namespace carat
