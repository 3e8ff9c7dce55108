#include "carat/codec/colour.hpp"

#include <algorithm>
#include <cmath>

#include "carat/globe/bounds.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"

namespace carat {

std::array<int, 3> ycocg_of_rgb(const std::array<int, 3>& p) {
    const int co = p[0] - p[2], t = p[2] + (co >> 1), cg = p[1] - t;
    return {t + (cg >> 1), co, cg};
}

std::array<std::uint8_t, 3> rgb_of_ycocg(const std::array<std::int32_t, 3>& p) {
    const std::int64_t t = std::int64_t{p[0]} - (p[2] >> 1), b = t - (p[1] >> 1);
    const auto clamped = [](std::int64_t x) {
        return static_cast<std::uint8_t>(std::clamp<std::int64_t>(x, 0, 255));
    };
    return {clamped(b + p[1]), clamped(t + p[2]), clamped(b)};
}

ColourTolerances split_tolerance(int tolerance) {
    ColourTolerances out;
    out.y = (tolerance + 1) / 2;
    const int rest = tolerance - out.y;  // shared by the halves of Co and Cg
    out.co = 2 * ((rest + 1) / 2);
    out.cg = 2 * (rest / 2);
    return out;
}

std::shared_ptr<const ColourRepository> ColourRepository::open(const std::filesystem::path& file,
                                                               std::size_t cache_bytes) {
    auto out = std::make_shared<ColourRepository>();
    auto sources = open_colour_planes(file);
    for (std::size_t k = 0; k < kColourPlanes; ++k) {
        out->planes_[k] = Repository::open(std::move(sources[k]));
        out->surfaces_[k] = std::make_unique<Surface>(out->planes_[k], cache_bytes / kColourPlanes);
        const RepositoryHeader &h = out->planes_[k]->header(), &first = out->header();
        if (h.quantum != 1 || h.n() != first.n() || h.deepest_level != first.deepest_level ||
            h.refined_diamonds != first.refined_diamonds || h.body_a != first.body_a ||
            h.body_b != first.body_b)
            throw Error(ErrorCode::corrupt, file.string() + ": its planes contradict each other");
    }
    out->tolerance_ = colour_tolerance(file);
    out->body_ = out->header().ellipsoid();
    out->file_bytes_ = std::filesystem::file_size(file);
    return out;
}

// Colours of places that lie close together: keeps the last leaf.
class ColourRepository::Cursor {
  public:
    explicit Cursor(const ColourRepository& file) : file_(file), cells_(file.header().cells()) {}

    // Red, green and blue, 0 to 255.
    std::array<double, 3> at(const RealLattice& place, bool& at_lattice) {
        const Location here = location(place);
        // Rounding must not push the place over the longest edge: the other half may be absent.
        const double s = half_.side == 0 ? here.s : std::min(here.s, here.t);
        const double t = half_.side == 0 ? std::min(here.s, here.t) : here.t;
        const TriangleWeights w =
            triangle_weights(std::clamp(s, 0.0, 1.0) * cells_, std::clamp(t, 0.0, 1.0) * cells_, cells_);
        std::array<double, 3> out{};
        for (std::size_t k = 0; k < 3; ++k) {
            if (w.weight[k] == 0) continue;  // a corner outside the half
            const auto rgb = vertex(w.vertex[k][0], w.vertex[k][1]);
            for (std::size_t c = 0; c < 3; ++c) out[c] += w.weight[k] * rgb[c];
            at_lattice |= w.weight[k] == 1;
        }
        return out;
    }

    void enter(const Half& half) {
        half_ = half;
        for (std::size_t k = 0; k < kColourPlanes; ++k)
            heights_[k] = file_.surfaces_[k]->heights(half.diamond);
    }
    std::array<std::uint8_t, 3> vertex(int i, int j) const {
        return rgb_of_ycocg({heights_[0]->at(i, j), heights_[1]->at(i, j), heights_[2]->at(i, j)});
    }
    const Half& half() const { return half_; }

  private:
    Location location(const RealLattice& place) {
        if (heights_[0] && place.face == face_) {
            const Location here = locate_in(place, half_);
            constexpr double kSlack = 1e-12;
            const double across = half_.side == 0 ? here.s - here.t : here.t - here.s;
            if (std::min({here.s, here.t, across}) >= -kSlack && std::max(here.s, here.t) <= 1 + kSlack)
                return here;
        }
        face_ = place.face;
        enter(leaf_half(*file_.planes_[0], place));
        return locate_in(place, half_);
    }

    const ColourRepository& file_;
    const int cells_;
    Half half_;
    int face_ = -1;
    std::array<std::shared_ptr<const Heights>, kColourPlanes> heights_;
};

ColourRepository::Sample ColourRepository::sample(const RealLattice& place) const {
    Cursor cursor(*this);
    Sample out;
    const std::array<double, 3> rgb = cursor.at(place, out.at_lattice);
    for (std::size_t c = 0; c < 3; ++c) out.rgb[c] = static_cast<std::uint8_t>(std::lround(rgb[c]));
    out.spacing = sample_spacing(body_, cursor.half().diamond, header().cells());
    return out;
}

void ColourRepository::sample(const Half& half, std::span<std::uint32_t> rgba) const {
    const int cells = header().cells(), level = half.diamond.level();
    const auto pack = [](const auto& rgb) {
        const auto byte = [](double x) { return static_cast<std::uint32_t>(std::lround(x)); };
        return byte(rgb[0]) | byte(rgb[1]) << 8 | byte(rgb[2]) << 16 | 0xff000000u;
    };
    Cursor cursor(*this);
    // The half exists if its parent on that side is refined.
    const bool exists = level == 0 || refined(*parent(half.diamond, half.side));
    if (exists) cursor.enter(half);
    const HalfFrame frame = half_frame(half, cells);
    for (int r = 0; r <= cells; ++r)
        for (int c = 0; c <= r; ++c) {
            const int i = half.side == 0 ? r : c, j = half.side == 0 ? c : r;
            std::uint32_t& out = rgba[half_vertex_index(i, j)];
            if (exists) {
                out = pack(cursor.vertex(i, j));
                continue;
            }
            const LatticePoint p = frame.vertex(i, j);
            bool at_lattice = false;
            out = pack(cursor.at({face_of(p), {double(p.x), double(p.y), double(p.z)}}, at_lattice));
        }
}

}  // namespace carat
