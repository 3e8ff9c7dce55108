// Writing a .carat repository: docs/format.md.
#pragma once

#include <array>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <span>
#include <vector>

#include "carat/codec/diamond_codec.hpp"
#include "carat/codec/repository.hpp"
#include "carat/codec/summary.hpp"

namespace carat {

// A refined diamond, ready for the file.
struct DiamondRecord {
    DiamondId id;
    EncodedResiduals residuals;
    std::array<SummaryValues, 2> summary;  // of its halves
};

// What the writer must know of a refined diamond ahead of its blob.
struct DiamondEntry {
    DiamondId id;
    BlobInfo info;
    std::uint64_t blob_bytes = 0;
    std::array<SummaryValues, 2> summary;  // of its halves
};
// Writes the blob of entry `index`, of just blob_bytes, to out.
using BlobSource = std::function<void(std::size_t index, std::vector<std::byte>& out)>;

// Pages of an older file with the same quantum, body and N.
class PageStock {
  public:
    virtual ~PageStock() = default;
    // Calls add with each part of a page, as it lies in the older file, if that page has `diamonds` refined
    // diamonds and is no zero page; else returns false.
    virtual bool copy(std::uint64_t key, std::size_t diamonds,
                      const std::function<void(int first_slot, std::span<const std::byte>)>& add) const = 0;
};
struct OldPages {
    const PageStock* stock = nullptr;
    std::function<bool(std::size_t index)> unchanged;  // an entry, its blob and its summaries
};

// The quantised root heights: what a reader will see, and their bytes.
struct EncodedRoots {
    std::array<std::vector<std::int32_t>, kFaces> heights;  // reconstructed, N x N each
    std::vector<std::byte> bytes;
};
// source[f]: N x N heights of face f, equal where faces share points. radius: quantiser radius of the root
// values.
EncodedRoots encode_roots(const std::array<std::vector<std::int32_t>, kFaces>& source, int n,
                          std::int32_t radius);

// What the writer must know before the first page.
struct WriterSetup {
    int log2_cells = 6;
    double quantum = 0, tolerance = 0;
    Ellipsoid body = Ellipsoid::earth();
    std::string vertical_datum = "unstated";
    std::string provenance = "{}";     // JSON
    Coding coding;                     // of every record's residuals; `orders` is not stored
    double rms_tolerance = 0;          // metres; 0: not promised
    std::uint64_t expected_bytes = 0;  // of the file, for the message of a full disk
    std::vector<std::int32_t> radii;  // radii[0]: root values; radii[l + 1]: residuals of diamonds of level l
};

// Writes to `path` + ".partial" and renames when complete; removes the partial file if never finished.
// Not thread-safe.
class RepositoryWriter {
  public:
    // Throws Error(io) if the file cannot be created.
    RepositoryWriter(std::filesystem::path path, WriterSetup setup, const EncodedRoots& roots);
    ~RepositoryWriter();
    RepositoryWriter(const RepositoryWriter&) = delete;
    RepositoryWriter& operator=(const RepositoryWriter&) = delete;

    // All refined diamonds, any order; sorts them into pages and writes. Call once. Throws Error(usage) if a
    // diamond comes twice.
    void write(std::vector<DiamondRecord> diamonds);
    // The same with the blobs asked for page by page, one page at a time in memory. Pages whose diamonds are
    // all unchanged are copied as they are in the older file, if there is one.
    void write(std::span<const DiamondEntry> diamonds, const BlobSource& blobs, const OldPages& old = {});
    // Directory and header: the partial file, whose path it returns, can be opened as a repository. Throws
    // Error(usage) for a setup that readers refuse: radii not one more than the levels refined, or above what
    // the tolerance allows.
    const std::filesystem::path& complete();
    // After complete(): replaces the provenance by one that is no longer; spaces fill the rest. Throws
    // Error(usage) if it is longer.
    void replace_provenance(std::string provenance);
    // Completes the file unless that is done; it appears under its name. Returns its size in bytes.
    std::uint64_t finish();

  private:
    struct State;
    std::unique_ptr<State> state_;
};

}  // namespace carat
