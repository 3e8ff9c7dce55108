// S at very many neighbouring places: the leaves that the last ones fell into are kept at hand.
#pragma once

#include <array>
#include <memory>
#include <vector>

#include "carat/codec/surface.hpp"
#include "carat/globe/patch.hpp"

namespace carat {

// A surface of leaf halves: that of a file, or that of a build before anything is quantised. Thread-safe.
class LeafSurface {
  public:
    virtual ~LeafSurface() = default;
    virtual int cells() const = 0;
    virtual Half leaf(const RealLattice& place) const = 0;
    // Heights in metres of the vertices of a leaf half, (cells + 1)^2 row-major; those outside the half are
    // not set. out has that size.
    virtual void heights(const Half& leaf, std::vector<double>& out) const = 0;
};

// S of a file.
class FileSurface final : public LeafSurface {
  public:
    FileSurface(std::shared_ptr<const Repository> file, std::size_t memory_bytes)
        : surface_(std::move(file), memory_bytes) {}
    int cells() const override { return surface_.repository().header().cells(); }
    Half leaf(const RealLattice& place) const override { return leaf_half(surface_.repository(), place); }
    void heights(const Half& leaf, std::vector<double>& out) const override;

  private:
    Surface surface_;
};

// For one thread. The surface must outlive it.
class LeafEvaluator {
  public:
    explicit LeafEvaluator(const LeafSurface& surface);

    // Height in metres at a place.
    double operator()(const RealLattice& place);
    // The leaf half that the last place fell into.
    const Half& leaf() const { return leaves_[current_].half; }

  private:
    struct Leaf {
        Half half;
        int face = -1;
        std::array<double, 4> i{}, j{};  // index coordinates: i[0..2] . coordinates + i[3]
        std::vector<double> heights;
    };
    bool holds(const Leaf& leaf, const RealLattice& place, double& i, double& j) const;
    std::size_t find(const RealLattice& place, double& i, double& j);
    void load(Leaf& leaf, const RealLattice& place) const;

    static constexpr std::size_t kLeaves = 64;
    const LeafSurface& surface_;
    int cells_;
    std::array<Leaf, kLeaves> leaves_;
    std::size_t current_ = 0, oldest_ = 0;
};

}  // namespace carat
