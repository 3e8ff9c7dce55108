#include "build_tree.hpp"

#include <cassert>

namespace carat {

BuildDiamond* BuildTree::find(DiamondId d) {
    const auto it = index_.find(d);
    return it == index_.end() ? nullptr : it->second;
}

void BuildTree::index() {
    index_.clear();
    index_.reserve(count());
    for (auto& level : levels)
        for (BuildDiamond& d : level) index_[d.id] = &d;
}

std::uint64_t BuildTree::count() const {
    std::uint64_t sum = 0;
    for (const auto& level : levels) sum += level.size();
    return sum;
}

const std::int32_t* half_heights(const BuildTree& tree, const Half& half, int n,
                                 std::vector<std::int32_t>& scratch) {
    if (const BuildDiamond* own = tree.find(half.diamond)) return own->p.data();
    const DiamondId up = *parent(half.diamond, half.side);
    const BuildDiamond* source = tree.find(up);
    assert(source != nullptr);
    scratch.resize(static_cast<std::size_t>(n * n));
    gather_half(source->refined, up, half, scratch.data());
    return scratch.data();
}

}  // namespace carat
