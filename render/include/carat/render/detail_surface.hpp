// The surface with procedural detail, anywhere: what is drawn where refinement goes to the end.
#pragma once

#include <memory>

#include "carat/codec/surface.hpp"
#include "carat/render/detail.hpp"

namespace carat {

// Thread-safe. A place costs a refinement or more for every level below the leaf, unless places near it were
// asked before.
class DetailSurface {
  public:
    // detail: of the repository's header. cache_bytes bounds the memory kept, half for each of the file and
    // the detail (at least 60 MB: what one place needs).
    DetailSurface(std::shared_ptr<const Repository> repository, std::shared_ptr<const Detail> detail,
                  std::size_t cache_bytes = 256u << 20);
    ~DetailSurface();

    struct Sample {
        double height = 0;         // metres above the file's datum surface
        double spacing = 0;        // metres between samples there
        bool at_lattice = false;   // the place is a sample of the file: as without detail
        bool synthesised = false;  // it is not, and detail goes further than the file there
    };
    // Throws what the repository throws.
    Sample sample(const RealLattice& place) const;

    // Heights of a half of any level, in the file or below it, with roughness where it is a leaf or below.
    std::shared_ptr<const HalfHeights> heights(const Half& half) const;

  private:
    struct Cache;
    std::shared_ptr<const Repository> repository_;
    std::shared_ptr<const Detail> detail_;
    Surface surface_;
    Ellipsoid body_;
    std::unique_ptr<Cache> cache_;
};

}  // namespace carat
