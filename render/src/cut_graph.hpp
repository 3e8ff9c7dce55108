// The diamonds that a cut has touched, linked to parents and children.
#pragma once

#include <array>
#include <memory>
#include <unordered_map>
#include <utility>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/render/cut.hpp"

namespace carat {

struct CutNode;

struct CutHalf {
    CutNode* node = nullptr;
    int side = 0;
    bool exists = false;
    bool in_file = false;  // the file holds it: level 0, or its parent is refined by the file
    Culled culled = Culled::none;
    double error = 0, delta = 0;
    HalfHeights heights;  // empty until the parent is decoded, and once this diamond is

    Half half() const;
};

struct CutNode {
    DiamondId id;
    int level = 0;
    bool in_file = false;  // the file refines it
    bool refined = false;
    std::array<CutHalf, 2> halves;
    // Filled on refinement: halves[2h] and halves[2h + 1] tile half h.
    std::array<CutHalf*, 4> child_halves{};
};

inline Half CutHalf::half() const { return {node->id, side}; }

// Not thread-safe, except that distinct nodes and halves may be worked on by distinct threads while no
// diamond is refined.
class CutGraph {
  public:
    // Starts with the six faces, none refined.
    explicit CutGraph(const Repository& repository);

    // Marks a diamond and whatever it needs above it as refined. No effect if it is already.
    void refine(CutNode& node);

    // Halves that have come to exist, and diamonds refined, since the last call; parents first.
    std::vector<CutHalf*> take_new_halves() { return std::exchange(new_halves_, {}); }
    std::vector<CutNode*> take_new_refined() { return std::exchange(new_refined_, {}); }

    std::uint64_t refined() const { return refined_; }
    const std::unordered_map<DiamondId, std::unique_ptr<CutNode>, DiamondIdHash>& nodes() const {
        return nodes_;
    }

  private:
    CutNode& node(DiamondId id, int level);
    void add_half(CutNode& node, int side, bool in_file);

    const Repository& repository_;
    std::unordered_map<DiamondId, std::unique_ptr<CutNode>, DiamondIdHash> nodes_;
    std::uint64_t refined_ = 0;
    std::vector<CutHalf*> new_halves_;
    std::vector<CutNode*> new_refined_;
};

}  // namespace carat
