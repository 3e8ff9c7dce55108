// A repository in memory whose heights are a formula, with summaries by brute force.
#pragma once

#include <atomic>
#include <functional>
#include <unordered_map>
#include <unordered_set>

#include "carat/codec/repository.hpp"

namespace carat::test {

struct FakeOptions {
    Ellipsoid body = Ellipsoid::earth();
    int log2_cells = 3;
    double quantum = 1.0 / 256;                 // metres
    std::function<double(const Vec3&)> relief;  // metres, of a geodetic normal
    int depth = 5;                              // every diamond above this level is refined
    // Refined to this level around a place, as conformity asks elsewhere.
    int deep = 0;
    Vec3 deep_centre{1, 0, 0};
    double deep_radius = 0;  // chord
    // Quanta: refined interior vertices move by up to this, as they do in a file with residuals of vertices.
    int wobble = 0;
};

// Smooth at planet scale, rough below, a few kilometres high; every octave contributes.
double rough_relief(const Vec3& n);

class FakeRepository : public Repository {
  public:
    explicit FakeRepository(FakeOptions options);

    const RepositoryHeader& header() const override { return header_; }
    std::uint64_t file_bytes() const override { return 0; }
    // Decoded: what has been refined.
    ReadCounters counters() const override { return {0, 0, refinements_, 0}; }
    bool refined(DiamondId d) const override { return refined_.contains(d); }
    HalfSummary summary(const Half& half) const override { return summaries_.at(half); }
    Heights root(int face) const override { return heights_.at(root_diamond(face)); }
    void refine(DiamondId d, const Heights& p, RefinedHeights& out) const override;

    const Ellipsoid& body() const { return body_; }
    // P of any diamond of the file.
    const Heights& heights(DiamondId d) const { return heights_.at(d); }
    // The leaf half that contains a half at or below it.
    Half leaf_above(Half half) const;
    // The leaf half that contains a lattice point of a half, wherever the half is.
    Half leaf_at(const Half& half, const LatticePoint& p) const;
    // S at a lattice point of a leaf, in quanta: linear between the leaf's three vertices.
    double surface(const Half& leaf, const LatticePoint& p) const;
    // S at a place, metres above the ellipsoid.
    double surface(const Geodetic& place) const;
    // The point of S, metres.
    Vec3 surface_point(const Half& leaf, const LatticePoint& p) const;

  private:
    std::int32_t sample(const LatticePoint& p, int level) const;
    void choose_refined();
    void decode_all();
    void summarise_all();
    void summarise_leaf(const Half& leaf);
    Vec3 vertex(const Half& half, int i, int j) const;

    FakeOptions options_;
    mutable std::atomic<std::uint64_t> refinements_{0};
    Ellipsoid body_;
    RepositoryHeader header_;
    std::unordered_set<DiamondId, DiamondIdHash> refined_;
    std::unordered_map<DiamondId, Heights, DiamondIdHash> heights_;
    std::unordered_map<Half, HalfSummary, HalfHash> summaries_;
};

}  // namespace carat::test
