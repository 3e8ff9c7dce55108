// Reading a .carat repository. docs/format.md is the law.
//
// A Repository is immutable after open() and safe to use from many threads at once. Every byte it reads is
// checked: a damaged file gives Error(corrupt|truncated|unsupported|limit|io) naming the file and the page,
// never a crash, and no allocation larger than the file's size justifies.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/heights.hpp"
#include "carat/globe/diamond.hpp"
#include "carat/globe/ellipsoid.hpp"

namespace carat {

// What a file says of itself.
struct RepositoryHeader {
    std::uint32_t format_version = 0;
    int log2_cells = 6;             // p: N = 2^p + 1
    double quantum = 0;             // metres a unit of height
    double tolerance = 0;           // metres: |reconstructed - source| at lattice points
    double rms_tolerance = 0;       // metres: RMS of the same over the whole file; 0: not promised
    std::string coder;              // "gamma" or "range"
    bool fitted_tables = false;     // of the range coder, stored in the file
    double body_a = 0, body_b = 0;  // semi-axes, metres
    std::string body;               // "earth", "moon", "mars" or ""
    std::string vertical_datum;     // "ellipsoid", "egm96", ..., "unstated"
    int deepest_level = 0;  // greatest level of any existing diamond (one more than the deepest refined)
    std::int32_t min_height = 0, max_height = 0;  // of the whole file, quanta
    std::uint64_t refined_diamonds = 0;
    std::string provenance;  // JSON, no times, hosts or absolute paths

    int n() const { return (1 << log2_cells) + 1; }
    int cells() const { return 1 << log2_cells; }
    Ellipsoid ellipsoid() const { return {body_a, body_b, body}; }
};

// Bounds of one half, rounded outwards. min and max hold for every height of the half and of all its
// descendants; delta bounds the 3-D distance between the flat patch drawn at the half and the reference
// surface S. Metres.
struct HalfSummary {
    double min_height = 0, max_height = 0, delta = 0;
};

// What has been read so far. Monotonic; read it before and after to see what a piece of work cost.
struct ReadCounters {
    std::uint64_t pages = 0, bytes = 0, diamonds_decoded = 0, diamonds_zero = 0;
};

class Repository {
  public:
    // Opens a local file; pages are read and checked when first needed.
    static std::shared_ptr<const Repository> open(const std::filesystem::path& file);
    static std::shared_ptr<const Repository> open(std::unique_ptr<ByteSource> source);
    virtual ~Repository() = default;

    virtual const RepositoryHeader& header() const = 0;
    virtual std::uint64_t file_bytes() const = 0;
    virtual ReadCounters counters() const = 0;

    // True if the file refines this diamond (its children's halves exist).
    virtual bool refined(DiamondId d) const = 0;
    // Summary of a half of a diamond; precondition: the half exists (level 0, or its parent is refined).
    // For a half whose diamond is not refined (a leaf): min and max of the parent half, and the sagitta as
    // delta.
    virtual HalfSummary summary(const Half& half) const = 0;
    // Vertex heights of a face diamond; both halves.
    virtual Heights root(int face) const = 0;
    // Decodes V and C of a refined diamond from its P. Integer arithmetic only: the same bits everywhere.
    // Precondition: p has both halves and n() * n() values (asserted only: without assertions fewer are
    // undefined behaviour). Throws Error(usage) if the file does not refine d, Error(corrupt|truncated|io) as
    // damage has it; `out` is then unspecified.
    virtual void refine(DiamondId d, const Heights& p, RefinedHeights& out) const = 0;
};

}  // namespace carat
