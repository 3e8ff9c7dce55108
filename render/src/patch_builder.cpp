#include "carat/render/patch_builder.hpp"

#include <cassert>

#include "carat/globe/patch.hpp"
#include "carat/render/vertex_position.hpp"
#include "patch_kernel.hpp"
#include "position_fit.hpp"

namespace carat {
namespace {

constexpr int kLeastFittedCells = 16;  // smaller patches are nearly all border

}  // namespace

PatchBuilder::PatchBuilder(const Ellipsoid& body, double quantum, int cells,
                           std::shared_ptr<const ColourRepository> colour)
    : body_(body), quantum_(quantum), unit_(length_unit(body)), cells_(cells), colour_(std::move(colour)) {
    if (cells < kLeastFittedCells) return;
    for (std::size_t level = 0; level < fits_.size(); ++level)
        fits_[level] = fit_order(body, static_cast<int>(level));
}

std::shared_ptr<PatchMesh> PatchBuilder::build(const Half& half, const HalfHeights& heights) const {
    auto out = std::make_shared<PatchMesh>();
    build(half, heights, *out);
    return out;
}

void PatchBuilder::build(const Half& half, const HalfHeights& heights, PatchMesh& out) const {
    assert(heights.size() == half_vertex_count(cells_));
    out.half = half;
    out.vertices.resize(heights.size());
    const HalfFrame frame = half_frame(half, cells_);
    const LatticePoint x = half.side == 0 ? frame.vertex(cells_, 0) : frame.vertex(0, cells_);
    const double metres = heights.fine.empty() ? quantum_ : quantum_ * kHeightFraction;
    const std::int64_t x_height = heights.fine.empty() ? heights.whole[half_vertex_index(cells_, 0)]
                                                       : heights.fine[half_vertex_index(cells_, 0)];
    out.anchor = vertex_position(body_, x, static_cast<double>(x_height) * metres, unit_);

    const std::array<TangentTable, 3> tangents{
        {{frame, half.side, 0, cells_}, {frame, half.side, 1, cells_}, {frame, half.side, 2, cells_}}};
    thread_local PositionFit scratch;
    const PositionFit* fit = nullptr;
    if (const FitOrder* order = fits_[static_cast<std::size_t>(half.diamond.level())]; order != nullptr) {
        fit_positions(body_, half, cells_, *order, scratch);
        fit = &scratch;
    }
    const PatchShape shape{cells_,
                           half.side,
                           body_.a() * body_.a(),
                           body_.b() * body_.b(),
                           1 / unit_,
                           metres,
                           {&tangents[0], &tangents[1], &tangents[2]},
                           out.anchor,
                           fit};
    if (heights.fine.empty())
        build_vertices(shape, heights.whole, out.vertices.data());
    else
        build_vertices(shape, heights.fine, out.vertices.data());
    if (colour_) {
        out.colours.resize(heights.size());
        colour_->sample(half, out.colours);
    }
}

}  // namespace carat
