// The diamond hierarchy on a plane: a raster coded by the codec's kernel on exactly its own samples.
//
// The plane is the face +z of the cube of globe/, cut to the raster. With N = 65 the face carries a square of
// S = 64 * 2^k + 1 samples at level 2k, the least square that covers the raster: sample (x, y) is the lattice
// point at (x, y) * 2^(25 - k) from the face's corner. Levels 0 .. 2k-1 are refined, where a diamond is
// needed for a leaf (level 2k) that holds a sample.
//
//   outside the raster        vertices are the mean of the diamond's vertices inside; nothing is coded: the
//                             residuals there are zero
//   roots                     one face: the raw vertices, charged as the root code of docs/format.md
//   size                      blobs + 4 bytes of index a refined diamond + roots + tables
//
// Integer samples: quantum 1, radius floor(tolerance), so the step is 2 floor(tolerance) + 1. Float samples:
// the codec's default quantum and radius.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "carat/bench/kernel.hpp"
#include "carat/bench/raster.hpp"

namespace carat::bench {

inline constexpr int kPlaneCells = 64, kPlaneN = kPlaneCells + 1;
inline constexpr std::size_t kIndexBytes =
    4;  // a refined diamond: mode and coder 1, length 2, rest of a page 1

// Map of a diamond's index grid to samples: vertex (i, j) lies at ((x, y) + 2 i u + 2 j v) / 2, the centre of
// cell (i, j) at ((x, y) + (2 i + 1) u + (2 j + 1) v) / 2. Exact wherever it is asked.
struct PixelFrame {
    int x = 0, y = 0, ux = 0, uy = 0, vx = 0, vy = 0;
};

// One diamond to visit, with where its parents' refined heights lie.
struct PlaneStep {
    DiamondId id;
    std::array<bool, 2> has{};          // halves inside the face
    std::array<DiamondId, 2> parent{};  // of each half
    std::array<int, 2> parent_step{-1, -1};
    std::array<int, 2> parent_slot{-1, -1};
    std::array<ChildMap, 2>
        map{};  // from rows and columns of a half to its parent: a leaf's are the raster's
    std::array<Triangle, 2> part{Triangle::left_lower, Triangle::right_upper};
    int slot = -1;  // of its own refined heights; -1: a leaf
    int level = 0;
    PixelFrame frame;
};

// The order of visiting: every diamond after its parents, leaves near each other; slots are used again.
struct PlanePlan {
    int k = 0, width = 0, height = 0, slots = 0;
    std::size_t refined = 0, leaves = 0;
    std::vector<PlaneStep> steps;

    // Throws Error(limit) for a raster wider or higher than 2^20 samples, Error(usage) for an empty one.
    static PlanePlan of(int width, int height);
};

// Cycles of the processor's time stamp counter, by part of the work.
struct PlaneCycles {
    std::uint64_t gather = 0, kernel = 0, store = 0;
};

class PlaneCodec {
  public:
    PlaneCodec(const Raster& shape, const KernelChoice& choice, double tolerance);

    double quantum() const { return quantum_; }
    const PlanePlan& plan() const { return plan_; }
    // Codes the raster; returns the size in bytes.
    std::size_t encode(const Raster& raster);
    // Tokens of the last encoding, if asked for before.
    void count_tokens() { statistics_ = std::make_unique<RangeStatistics>(); }
    const RangeStatistics& tokens() const { return *statistics_; }
    void set_tables(std::shared_ptr<const RangeTables> tables) { kernel_.set_tables(std::move(tables)); }
    // Decodes all levels and writes the leaves into a raster of the same shape.
    void decode(Raster& out);

    // Of the last call.
    const PlaneCycles& cycles() const { return cycles_; }
    std::size_t zero_diamonds() const { return zero_; }
    std::size_t root_bytes() const { return root_bytes_; }

  private:
    struct Coded {
        BlobInfo info;
        std::size_t offset = 0, bytes = 0;
    };

    void encode_all();
    EncodedResiduals encode_step(std::size_t step);
    void read_heights(const Raster& raster);
    std::int32_t height_at(int x, int y) const;
    void keep_root(const std::vector<std::int32_t>& reference);
    void sample_reference(const PlaneStep& step, RefinedHeights& out) const;
    bool lies_inside(const PixelFrame& frame) const;
    void filter_references();
    void pass_up(const PlaneStep& step, const std::vector<std::int32_t>& p);
    const RefinedHeights& reference_of(std::size_t step, Order outside_order);
    void assemble(const PlaneStep& step);
    void take_root(const PlaneStep& step);
    struct Window;
    static Window window(const PlaneStep& leaf, const Raster& out);
    static void fetch_leaf(const PlaneStep& step, Raster& out);
    void store_leaf(const PlaneStep& step, Raster& out) const;

    double quantum_;
    Kernel kernel_;
    PlanePlan plan_;
    std::vector<RefinedHeights> slots_;
    std::vector<std::int32_t> p_, root_, predicted_, heights_;
    RefinedHeights reference_;
    std::vector<RefinedHeights> references_;  // by step; modes 1 and 2 only
    std::vector<Coded> coded_;                // by step
    std::vector<std::byte> blobs_;
    CodecScratch scratch_;
    std::unique_ptr<RangeStatistics> statistics_;
    PlaneCycles cycles_;
    std::size_t zero_ = 0, root_bytes_ = 0;
};

}  // namespace carat::bench
