#include "free_cut.hpp"

#include "carat/render/cut.hpp"

namespace carat::bench {
namespace {

class FreeCut {
  public:
    explicit FreeCut(const Repository& file)
        : file_(file), deepest_(deepest_refinable_level(file.header().log2_cells)) {
        for (int face = 0; face < kFaces; ++face)
            for (const int side : {0, 1}) {
                const Half half{root_diamond(face), side};
                add({half, half});
            }
    }

    bool run(const std::function<bool(const FreeHalf&)>& demands, std::size_t most) {
        while (!pending_.empty()) {
            const FreeHalf h = pending_.back();
            pending_.pop_back();
            if (refined_.contains(h.half.diamond) || h.half.diamond.level() >= deepest_ || !demands(h))
                continue;
            refine(h.half.diamond);
            if (refined_.size() > most) return false;
        }
        return true;
    }

    std::vector<FreeHalf> frontier() const {
        std::vector<FreeHalf> out;
        for (const auto& [half, of_file] : existing_)
            if (!refined_.contains(half.diamond)) out.push_back({half, of_file});
        return out;
    }

  private:
    void add(const FreeHalf& h) {
        existing_.emplace(h.half, h.of_file);
        pending_.push_back(h);
    }

    void refine(DiamondId d) {
        if (!refined_.insert(d).second) return;
        for (const int side : {0, 1})
            if (!existing_.contains({d, side})) refine(*parent(d, side));
        const bool by_file = existing_.at({d, 0}) == Half{d, 0} && d.level() < file_.header().deepest_level &&
                             file_.refined(d);
        for (const int side : {0, 1})
            for (const Half& child : child_halves({d, side}))
                add({child, by_file ? child : existing_.at({d, side})});
    }

    const Repository& file_;
    const int deepest_;
    std::unordered_map<Half, Half, HalfHash> existing_;
    std::unordered_set<DiamondId, DiamondIdHash> refined_;
    std::vector<FreeHalf> pending_;
};

}  // namespace

std::optional<std::vector<FreeHalf>> least_cut(const Repository& file,
                                               const std::function<bool(const FreeHalf&)>& demands,
                                               std::size_t most) {
    FreeCut cut(file);
    if (!cut.run(demands, most)) return std::nullopt;
    return cut.frontier();
}

}  // namespace carat::bench
