// The inner loop of detail: C of a diamond, in vectors of whatever width the processor has.
#pragma once

#include <array>
#include <cstdint>

#include "carat/globe/lattice.hpp"

namespace carat {

// Cell (i, j) of one side has its centre at origin + i u + j v, in the lattice step of the level's centres.
struct CellGrid {
    std::array<std::int32_t, 3> origin{}, u{}, v{};
};

struct SynthesisJob {
    int cells = 0;
    std::array<CellGrid, 2> sides;  // side 1: j > i
    std::uint32_t salt = 0;         // of seed and level
    std::int32_t cap = 0;           // greatest amplitude, log2 of quanta in 1/256
};

// Readable beyond the last value of every input, and writable beyond the last of every output.
inline constexpr int kSynthesisPadding = 16;

// v: (cells + 1)^2 heights, rough: their roughness. Fills the cells^2 heights and roughnesses of C.
void synthesise_centres(const SynthesisJob& job, const std::int64_t* v, const std::int32_t* rough,
                        std::int64_t* c, std::int32_t* rough_c);
// The roughness of the next level at the same vertices.
void decay_roughness(std::int32_t cap, std::int32_t* rough, std::size_t count);

// 32 bits from a point and a salt; every bit depends on all.
std::uint32_t detail_hash(std::int32_t x, std::int32_t y, std::int32_t z, std::uint32_t salt);

}  // namespace carat
