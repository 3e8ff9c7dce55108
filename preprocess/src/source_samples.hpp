// The samples of the sources themselves: where each lies, its height, and whether it is what S should show
// there.
#pragma once

#include <cstdint>
#include <vector>

#include "carat/preprocess/source.hpp"
#include "raster_file.hpp"

namespace carat {

class Grid;

// A part of one grid, small enough to be held by a thread.
struct SampleBlock {
    int layer = 0;
    const Grid* grid = nullptr;
    PixelWindow window;
};

// The valid samples of a block that are not hidden below a higher layer or raster.
struct BlockSamples {
    std::vector<RealLattice> places;
    // Metres, geoid included: the sample's own height, or, where layers blend, what they blend to at its
    // place.
    std::vector<double> heights;
    std::vector<std::uint8_t> blended;  // 1: in a feathered zone, where another layer or raster has a share
    std::uint64_t hidden = 0;           // left out: another one alone gives the height there

    void clear();
};

// Thread-safe once made; the stack must outlive it.
class SourceSamples {
  public:
    explicit SourceSamples(const SourceStack& stack);

    // Layer by layer; within a grid in bands of rows, column by column, so that neighbours follow each other.
    // The division depends on the files alone.
    const std::vector<SampleBlock>& blocks() const { return blocks_; }
    void read(const SampleBlock& block, BlockSamples& out) const;

  private:
    class Reader;

    const SourceStack::State& stack_;
    std::vector<SampleBlock> blocks_;
};

}  // namespace carat
