#include "carat/bench/plane.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "carat/codec/heights.hpp"
#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/error.hpp"
#include "cycles.hpp"
#include "plane_rim.hpp"

namespace carat::bench {
namespace {

constexpr int kN = kPlaneN, kCells = kPlaneCells;

std::size_t vertex(int i, int j) { return static_cast<std::size_t>(i * kN + j); }
std::size_t cell(int i, int j) { return static_cast<std::size_t>(i * kCells + j); }

// Visits (i, j) of a side of a size x size matrix, the diagonal included.
template <class Visit>
void for_side(int size, int side, Visit visit) {
    for (int i = 0; i < size; ++i)
        for (int j = side == 0 ? 0 : i; j < (side == 0 ? i + 1 : size); ++j) visit(i, j);
}

int absent_side(const PlaneStep& step) { return step.has[0] ? (step.has[1] ? -1 : 1) : 0; }

double quantum_of(const Raster& shape, double tolerance) {
    return shape.integer ? 1.0 : default_quantum(tolerance);
}

std::int32_t radius_of(const Raster& shape, double tolerance) {
    return shape.integer ? static_cast<std::int32_t>(std::floor(tolerance))
                         : quantizer_radius(tolerance, default_quantum(tolerance));
}

// Bits of the root code: the median predictor of the left, upper and upper left index, Elias-gamma coded.
// Outside the raster the index becomes what is predicted.
std::size_t root_code_bytes(std::vector<std::int32_t>& index, const PlanePlan& plan) {
    std::uint64_t bits = 0;
    for (int i = 0; i < kN; ++i) {
        const Columns inside = columns_inside(plan.steps[0].frame, plan, i, 0);
        for (int j = 0; j < kN; ++j) {
            std::int32_t guess = 0;
            if (i > 0 && j > 0) {
                const std::int32_t w = index[vertex(i, j - 1)], n = index[vertex(i - 1, j)];
                guess = static_cast<std::int32_t>(std::clamp<std::int64_t>(
                    std::int64_t{w} + n - index[vertex(i - 1, j - 1)], std::min(w, n), std::max(w, n)));
            } else if (i + j > 0) {
                guess = i == 0 ? index[vertex(0, j - 1)] : index[vertex(i - 1, 0)];
            }
            if (j < inside.begin || j >= inside.end) index[vertex(i, j)] = guess;
            const std::int64_t d = std::int64_t{index[vertex(i, j)]} - guess;
            const auto code = static_cast<std::uint64_t>(d >= 0 ? 2 * d : -2 * d - 1) + 1;
            bits += 2 * static_cast<std::uint64_t>(std::bit_width(code)) - 1;
        }
    }
    return static_cast<std::size_t>((bits + 7) / 8);
}

void mirror(RefinedHeights& r, int side) {
    for_side(kN, side, [&](int i, int j) { r.v[vertex(i, j)] = r.v[vertex(j, i)]; });
    for_side(kCells, side, [&](int i, int j) { r.c[cell(i, j)] = r.c[cell(j, i)]; });
}

void resize(RefinedHeights& r) {
    r.n = kN;
    r.v.resize(static_cast<std::size_t>(kN * kN));
    r.c.resize(static_cast<std::size_t>(kCells * kCells));
}

}  // namespace

PlaneCodec::PlaneCodec(const Raster& shape, const KernelChoice& choice, double tolerance)
    : quantum_(quantum_of(shape, tolerance)),
      kernel_(choice, radius_of(shape, tolerance)),
      plan_(PlanePlan::of(shape.width, shape.height)),
      slots_(static_cast<std::size_t>(plan_.slots)),
      p_(static_cast<std::size_t>(kN * kN)),
      predicted_(static_cast<std::size_t>(kCells * kCells)),
      coded_(plan_.steps.size()) {
    for (RefinedHeights& slot : slots_) resize(slot);
    resize(reference_);
}

void PlaneCodec::read_heights(const Raster& raster) {
    heights_.resize(raster.size());
    if (raster.integer) {
        std::copy(raster.whole.begin(), raster.whole.end(), heights_.begin());
        return;
    }
    constexpr double kGreatest = kGreatestHeight;
    std::transform(raster.real.begin(), raster.real.end(), heights_.begin(), [&](float x) {
        const double h = std::round(static_cast<double>(x) / quantum_);
        if (!(std::abs(h) <= kGreatest))
            throw Error(ErrorCode::limit, "heights beyond " + std::to_string(kGreatest * quantum_) +
                                              " m do not fit at this tolerance");
        return static_cast<std::int32_t>(h);
    });
}

std::int32_t PlaneCodec::height_at(int x, int y) const {
    const int inside_x = std::clamp(x, 0, plan_.width - 1), inside_y = std::clamp(y, 0, plan_.height - 1);
    return heights_[static_cast<std::size_t>(inside_y) * static_cast<std::size_t>(plan_.width) +
                    static_cast<std::size_t>(inside_x)];
}

void PlaneCodec::keep_root(const std::vector<std::int32_t>& reference) {
    root_.resize(reference.size());
    std::transform(reference.begin(), reference.end(), root_.begin(),
                   [&](std::int32_t h) { return quantize(h, kernel_.radius()); });
    root_bytes_ = root_code_bytes(root_, plan_);
    for (std::int32_t& h : root_) h = dequantize(h, kernel_.radius());
}

void PlaneCodec::sample_reference(const PlaneStep& step, RefinedHeights& out) const {
    const PixelFrame& f = step.frame;
    const int absent = absent_side(step);
    const auto fill = [&](int side, auto at) {
        for_side(kN, side, [&](int i, int j) { out.v[vertex(i, j)] = at(2 * i, 2 * j); });
        for_side(kCells, side, [&](int i, int j) { out.c[cell(i, j)] = at(2 * i + 1, 2 * j + 1); });
    };
    const auto fill_sides = [&](auto at) {
        if (absent != 0) fill(0, at);
        if (absent != 1) fill(1, at);
    };
    if (!lies_inside(f) || absent >= 0) {
        fill_sides([&](int p, int q) {
            return height_at((f.x + p * f.ux + q * f.vx) / 2, (f.y + p * f.uy + q * f.vy) / 2);
        });
        return;
    }
    // Doubled coordinates of a vertex or a centre are even: a step of two in p or q is a step in the raster.
    const std::ptrdiff_t width = plan_.width, u = f.uy * width + f.ux, v = f.vy * width + f.vx;
    const std::int32_t* from = heights_.data() + (f.y / 2 * width + f.x / 2);
    const std::int32_t* centre =
        heights_.data() + ((f.y + f.uy + f.vy) / 2 * width + (f.x + f.ux + f.vx) / 2);
    for (int i = 0; i < kN; ++i)
        for (int j = 0; j < kN; ++j) out.v[vertex(i, j)] = from[i * u + j * v];
    for (int i = 0; i < kCells; ++i)
        for (int j = 0; j < kCells; ++j) out.c[cell(i, j)] = centre[i * u + j * v];
}

bool PlaneCodec::lies_inside(const PixelFrame& f) const {
    for (const int p : {0, 2 * kCells})
        for (const int q : {0, 2 * kCells}) {
            const int x = f.x + p * f.ux + q * f.vx, y = f.y + p * f.uy + q * f.vy;
            if (x < 0 || y < 0 || x / 2 >= plan_.width || y / 2 >= plan_.height) return false;
        }
    return true;
}

// Analysis, fine to coarse: the reference P of every diamond becomes V and C of its parents.
void PlaneCodec::filter_references() {
    references_.resize(plan_.steps.size());
    for (std::size_t k = 0; k < plan_.steps.size(); ++k) {
        if (plan_.steps[k].slot < 0) continue;
        resize(references_[k]);
        sample_reference(plan_.steps[k], references_[k]);
    }
    std::vector<std::int32_t> p(static_cast<std::size_t>(kN * kN));
    for (std::size_t k = plan_.steps.size(); k-- > 0;) {
        const PlaneStep& step = plan_.steps[k];
        if (step.slot < 0) continue;
        if (const int absent = absent_side(step); absent >= 0) mirror(references_[k], absent);
        filter_vertices(references_[k], p);
        if (step.level == 0)
            keep_root(p);
        else
            pass_up(step, p);
    }
}

void PlaneCodec::pass_up(const PlaneStep& step, const std::vector<std::int32_t>& p) {
    for (std::size_t side = 0; side < 2; ++side) {
        if (!step.has[side]) continue;
        RefinedHeights& above = references_[static_cast<std::size_t>(step.parent_step[side])];
        const ChildMap m = child_map(step.parent[side], {step.id, static_cast<int>(side)}, kCells);
        for_side(kN, static_cast<int>(side), [&](int i, int j) {
            const int a = m.p0 + i * m.pi + j * m.pj, b = m.q0 + i * m.qi + j * m.qj;
            ((a & 1) == 0 ? above.v[vertex(a >> 1, b >> 1)] : above.c[cell(a >> 1, b >> 1)]) =
                p[vertex(i, j)];
        });
    }
}

// What lies outside the raster nobody asks for: there the reference is what will be predicted.
const RefinedHeights& PlaneCodec::reference_of(std::size_t k, Order outside_order) {
    const PlaneStep& step = plan_.steps[k];
    if (kernel_.choice().mode == Mode::interpolating)
        sample_reference(step, reference_);
    else
        reference_ = references_[k];
    if (lies_inside(step.frame)) return reference_;
    predict_centres(p_.data(), kN, outside_order, predicted_.data());
    const auto take_outside = [&](int first, const std::vector<std::int32_t>& from,
                                  std::vector<std::int32_t>& to) {
        const int size = kN - first;
        for (int i = 0; i < size; ++i) {
            const Columns c = columns_inside(step.frame, plan_, i, first);
            for (int j = 0; j < size; ++j) {
                const auto at = static_cast<std::size_t>(i * size + j);
                if (j < c.begin || j >= c.end) to[at] = from[at];
            }
        }
    };
    take_outside(0, p_, reference_.v);
    take_outside(1, predicted_, reference_.c);
    return reference_;
}

// A root that is a leaf lies along the raster, like all leaves.
void PlaneCodec::take_root(const PlaneStep& step) {
    const PixelFrame& f = step.frame;
    const auto from_first = [](int sign, int at) { return sign > 0 ? at : kCells - at; };
    for (int i = 0; i < kN; ++i)
        for (int j = 0; j < kN; ++j) {
            const int a = from_first(f.ux + f.uy, i), b = from_first(f.vx + f.vy, j);
            const std::size_t along = f.ux != 0 ? vertex(b, a) : vertex(a, b);
            p_[step.slot < 0 ? along : vertex(i, j)] = root_[vertex(i, j)];
        }
}

void PlaneCodec::assemble(const PlaneStep& step) {
    if (step.level == 0) take_root(step);
    for (std::size_t side = 0; side < 2; ++side)
        if (step.parent_slot[side] >= 0)
            gather_half(slots_[static_cast<std::size_t>(step.parent_slot[side])], step.map[side],
                        step.part[side], p_.data());
    if (step.slot >= 0 && !lies_inside(step.frame)) fill_outside(step, plan_, p_);
}

// At the rim what lies outside must be what the order predicts: the order is found with what order 4 does.
EncodedResiduals PlaneCodec::encode_step(std::size_t k) {
    RefinedHeights& out = slots_[static_cast<std::size_t>(plan_.steps[k].slot)];
    scratch_.statistics = statistics_.get();
    const bool inside = lies_inside(plan_.steps[k].frame);
    if (!inside) scratch_.statistics = nullptr;
    EncodedResiduals e = kernel_.encode(p_, reference_of(k, Order::four), out, scratch_);
    if (inside) return e;
    scratch_.statistics = statistics_.get();
    return kernel_.encode_with(1u << static_cast<unsigned>(e.info.order), p_, reference_of(k, e.info.order),
                               out, scratch_);
}

void PlaneCodec::encode_all() {
    blobs_.clear();
    zero_ = 0;
    for (std::size_t k = 0; k < plan_.steps.size(); ++k) {
        const PlaneStep& step = plan_.steps[k];
        if (step.slot < 0) continue;
        assemble(step);
        const EncodedResiduals e = encode_step(k);
        coded_[k] = {e.info, blobs_.size(), e.blob.size()};
        blobs_.insert(blobs_.end(), e.blob.begin(), e.blob.end());
        zero_ += e.blob.empty() ? 1 : 0;
    }
}

std::size_t PlaneCodec::encode(const Raster& raster) {
    read_heights(raster);
    if (kernel_.choice().mode != Mode::interpolating && plan_.k > 0) {
        filter_references();
    } else {
        std::vector<std::int32_t> root(p_.size());
        const PixelFrame& f = plan_.steps[0].frame;
        for (int i = 0; i < kN; ++i)
            for (int j = 0; j < kN; ++j)
                root[vertex(i, j)] = height_at(f.x / 2 + i * f.ux + j * f.vx, f.y / 2 + i * f.uy + j * f.vy);
        keep_root(root);
    }
    if (kernel_.choice().fit_tables) {
        count_tokens();
        kernel_.set_tables(RangeTables::built_in());
        encode_all();
        kernel_.set_tables(RangeTables::fit(*statistics_));
        statistics_.reset();
    }
    encode_all();
    return blobs_.size() + kIndexBytes * plan_.refined + root_bytes_ + kernel_.table_bytes();
}

// The part of the raster that is a leaf's.
struct PlaneCodec::Window {
    int width, height;
    std::size_t first, stride;

    std::size_t row(int y) const { return first + static_cast<std::size_t>(y) * stride; }
};

PlaneCodec::Window PlaneCodec::window(const PlaneStep& leaf, const Raster& out) {
    const PixelFrame& f = leaf.frame;
    const int x_sign = f.ux + f.vx, y_sign = f.uy + f.vy;
    const int left = x_sign > 0 ? f.x / 2 : f.x / 2 - kCells, top = y_sign > 0 ? f.y / 2 : f.y / 2 - kCells;
    const auto stride = static_cast<std::size_t>(out.width);
    return {std::min(kN, out.width - left), std::min(kN, out.height - top),
            static_cast<std::size_t>(top) * stride + static_cast<std::size_t>(left), stride};
}

// The rows lie far apart, where no processor expects them: they are fetched while the leaf is gathered.
void PlaneCodec::fetch_leaf(const PlaneStep& step, Raster& out) {
    const Window w = window(step, out);
    const std::size_t size = out.integer ? sizeof(std::int16_t) : sizeof(float);
    char* const bytes =
        out.integer ? reinterpret_cast<char*>(out.whole.data()) : reinterpret_cast<char*>(out.real.data());
    for (int y = 0; y < w.height; ++y)
        for (std::size_t at = 0; at < size * static_cast<std::size_t>(w.width); at += 64)
            __builtin_prefetch(bytes + size * w.row(y) + at, 1, 2);
}

void PlaneCodec::store_leaf(const PlaneStep& step, Raster& out) const {
    const Window w = window(step, out);
    for (int y = 0; y < w.height; ++y) {
        const std::int32_t *from = p_.data() + vertex(y, 0), *end = from + w.width;
        const std::size_t to = w.row(y);
        if (out.integer)
            std::transform(from, end, out.whole.data() + to, [](std::int32_t h) { return to_int16(h); });
        else
            std::transform(from, end, out.real.data() + to,
                           [q = quantum_](std::int32_t h) { return static_cast<float>(h * q); });
    }
}

void PlaneCodec::decode(Raster& out) {
    cycles_ = {};
    for (std::size_t k = 0; k < plan_.steps.size(); ++k) {
        const PlaneStep& step = plan_.steps[k];
        const std::uint64_t t0 = cycles_now();
        if (step.slot < 0) fetch_leaf(step, out);
        assemble(step);
        const std::uint64_t t1 = cycles_now();
        cycles_.gather += t1 - t0;
        if (step.slot < 0) {
            store_leaf(step, out);
            cycles_.store += cycles_now() - t1;
            continue;
        }
        const Coded& c = coded_[k];
        RefinedHeights& refined = slots_[static_cast<std::size_t>(step.slot)];
        // In mode 0 V is P: it may lie where V belongs already.
        const bool in_place = c.info.mode == Mode::interpolating;
        if (in_place) std::swap(refined.v, p_);
        kernel_.decode(c.info, std::span(blobs_).subspan(c.offset, c.bytes), in_place ? refined.v : p_, kN,
                       refined, scratch_);
        cycles_.kernel += cycles_now() - t1;
    }
}

}  // namespace carat::bench
