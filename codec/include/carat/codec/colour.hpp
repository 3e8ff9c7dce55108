// Colour: three planes of integers, each a repository of its own, in one file (docs/format.md, section 15).
//
//   planes   Y, Co, Cg of 8-bit sRGB through the reversible YCoCg-R (Malvar and Sullivan 2003), quantum 1
//   error    of each plane within its radius; every channel of RGB within tolerance(), clamped to [0, 255]
//   tree     the planes refine the same diamonds; a diamond that exists in one exists in all
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <span>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/repository.hpp"
#include "carat/codec/surface.hpp"

namespace carat {

inline constexpr std::size_t kColourPlanes = 3;

// Co = R - B;  t = B + (Co >> 1);  Cg = G - t;  Y = t + (Cg >> 1).
std::array<int, 3> ycocg_of_rgb(const std::array<int, 3>& rgb);
// Its inverse, clamped to [0, 255]. Any int32 values.
std::array<std::uint8_t, 3> rgb_of_ycocg(const std::array<std::int32_t, 3>& y_co_cg);

// Greatest errors of the planes. Every channel of RGB is then off by at most y + ceil(co / 2) + ceil(cg / 2).
struct ColourTolerances {
    int y = 0, co = 0, cg = 0;

    int rgb() const { return y + (co + 1) / 2 + (cg + 1) / 2; }
};
// A split that keeps RGB within `tolerance`, and about the smallest file of photographs: half to Y, the rest
// to Co before Cg. Precondition: 0 <= tolerance <= 255.
ColourTolerances split_tolerance(int tolerance);

// Where each plane lies in a colour file: a source of its bytes alone. Throws Error(corrupt, truncated,
// unsupported, io).
std::array<std::unique_ptr<ByteSource>, kColourPlanes> open_colour_planes(const std::filesystem::path& file);
// What a colour file promises: the greatest error of any channel, of 255. Throws as open_colour_planes().
int colour_tolerance(const std::filesystem::path& file);
// Whether a file begins like a colour file; false if it cannot be read.
bool is_colour_file(const std::filesystem::path& file);
// Joins three repositories to one file, under a temporary name first. Throws Error(io).
void write_colour_file(const std::filesystem::path& file,
                       const std::array<std::filesystem::path, kColourPlanes>& planes, int tolerance);

// An open colour file. Thread-safe.
class ColourRepository {
  public:
    // cache_bytes bounds the memory kept for decoded diamonds. Throws as Repository::open() does, and
    // Error(corrupt) if the planes contradict each other.
    static std::shared_ptr<const ColourRepository> open(const std::filesystem::path& file,
                                                        std::size_t cache_bytes = 256u << 20);

    // Of the plane Y: body, n, depth, number of diamonds, provenance.
    const RepositoryHeader& header() const { return planes_[0]->header(); }
    const Repository& plane(std::size_t k) const { return *planes_[k]; }
    // Of 255, in each channel, at every sample of the file at every level.
    int tolerance() const { return tolerance_; }
    std::uint64_t file_bytes() const { return file_bytes_; }

    bool refined(DiamondId d) const { return planes_[0]->refined(d); }

    struct Sample {
        std::array<std::uint8_t, 3> rgb{};
        double spacing = 0;  // metres between samples there
        bool at_lattice = false;
    };
    // At a place; linear in encoded values between samples, rounded.
    Sample sample(const RealLattice& place) const;

    // Of the vertices of a half in the order of half_vertex_index (globe/patch.hpp), red in the lowest byte,
    // the highest 255. Above or below the file's leaves alike: there interpolated. n() of both must agree.
    void sample(const Half& half, std::span<std::uint32_t> rgba) const;

  private:
    class Cursor;
    std::array<std::shared_ptr<const Repository>, kColourPlanes> planes_;
    std::array<std::unique_ptr<Surface>, kColourPlanes> surfaces_;
    Ellipsoid body_ = Ellipsoid::earth();
    std::uint64_t file_bytes_ = 0;
    int tolerance_ = 0;
};

}  // namespace carat
