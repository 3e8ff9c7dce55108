// The reference surface S of a repository: heights of any diamond or place, with a cache. Thread-safe.
#pragma once

#include <memory>

#include "carat/codec/heights.hpp"
#include "carat/codec/repository.hpp"
#include "carat/globe/ellipsoid.hpp"

namespace carat {

class Surface {
  public:
    // cache_bytes bounds the memory kept for decoded diamonds (at least a few dozen are kept).
    explicit Surface(std::shared_ptr<const Repository> repository, std::size_t cache_bytes = 256u << 20);
    ~Surface();

    const Repository& repository() const;

    // P of a diamond that exists in the file (at least one of its halves). Decodes ancestors as needed.
    std::shared_ptr<const Heights> heights(DiamondId d) const;
    // V and C of a refined diamond.
    std::shared_ptr<const RefinedHeights> refined_heights(DiamondId d) const;

    struct Sample {
        double height = 0;        // metres above the file's datum surface, S at the place
        double spacing = 0;       // metres between samples there
        Half half;                // leaf half that contains the place
        bool at_lattice = false;  // the place is a sample: |height - source| <= tolerance
    };
    // S at a place. Throws what the repository throws.
    Sample sample(const RealLattice& place) const;

  private:
    struct Cache;
    std::shared_ptr<const Repository> repository_;
    Ellipsoid body_;
    std::unique_ptr<Cache> cache_;
};

// The leaf half (in the file's full depth) that contains the place.
Half leaf_half(const Repository& repository, const RealLattice& place);

}  // namespace carat
