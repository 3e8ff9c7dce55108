#include "carat/bench/plane.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "carat/codec/predict.hpp"
#include "carat/codec/quantize.hpp"
#include "cycles.hpp"

namespace carat::bench {
namespace {

constexpr int kN = kPlaneN, kCells = kPlaneCells, kFadeRows = 16;

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
std::size_t root_code_bytes(const std::vector<std::int32_t>& index) {
    std::uint64_t bits = 0;
    for (int i = 0; i < kN; ++i)
        for (int j = 0; j < kN; ++j) {
            std::int32_t guess = 0;
            if (i > 0 && j > 0) {
                const std::int32_t w = index[vertex(i, j - 1)], n = index[vertex(i - 1, j)];
                guess = std::clamp(w + n - index[vertex(i - 1, j - 1)], std::min(w, n), std::max(w, n));
            } else if (i + j > 0) {
                guess = i == 0 ? index[vertex(0, j - 1)] : index[vertex(i - 1, 0)];
            }
            const std::int64_t d = std::int64_t{index[vertex(i, j)]} - guess;
            const auto code = static_cast<std::uint64_t>(d >= 0 ? 2 * d : -2 * d - 1) + 1;
            bits += 2 * static_cast<std::uint64_t>(std::bit_width(code)) - 1;
        }
    return static_cast<std::size_t>((bits + 7) / 8);
}

// Vertices of the absent half: the mirrored ones, faded to the mean, so that nothing there is worth coding.
void fade_in_mirror(std::vector<std::int32_t>& p, int side) {
    std::int64_t sum = 0, count = 0;
    for_side(kN, 1 - side, [&](int i, int j) {
        sum += p[vertex(i, j)];
        ++count;
    });
    const std::int64_t mean = sum / count;
    for_side(kN, side, [&](int i, int j) {
        const int weight = std::max(0, kFadeRows - std::abs(i - j));
        if (i != j)
            p[vertex(i, j)] = static_cast<std::int32_t>(mean + (p[vertex(j, i)] - mean) * weight / kFadeRows);
    });
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
    if (raster.integer)
        std::copy(raster.whole.begin(), raster.whole.end(), heights_.begin());
    else
        std::transform(raster.real.begin(), raster.real.end(), heights_.begin(), [&](float x) {
            return static_cast<std::int32_t>(std::llround(static_cast<double>(x) / quantum_));
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
    root_bytes_ = root_code_bytes(root_);
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

const RefinedHeights& PlaneCodec::reference_of(std::size_t k, Order absent_order) {
    const PlaneStep& step = plan_.steps[k];
    if (kernel_.choice().mode == Mode::interpolating)
        sample_reference(step, reference_);
    else
        reference_ = references_[k];
    const int absent = absent_side(step);
    if (absent < 0) return reference_;
    predict_centres(p_.data(), kN, absent_order, predicted_.data());
    for_side(kN, absent, [&](int i, int j) {
        if (i != j) reference_.v[vertex(i, j)] = p_[vertex(i, j)];
    });
    for_side(kCells, absent, [&](int i, int j) {
        if (i != j) reference_.c[cell(i, j)] = predicted_[cell(i, j)];
    });
    return reference_;
}

void PlaneCodec::assemble(const PlaneStep& step) {
    if (step.level == 0) {
        std::copy(root_.begin(), root_.end(), p_.begin());
        return;
    }
    for (std::size_t side = 0; side < 2; ++side)
        if (step.has[side])
            gather_half(slots_[static_cast<std::size_t>(step.parent_slot[side])], step.parent[side],
                        {step.id, static_cast<int>(side)}, p_.data());
    if (const int absent = absent_side(step); absent >= 0) fade_in_mirror(p_, absent);
}

// A diamond at the rim is coded with each order by itself: what is absent must be what that order predicts.
EncodedResiduals PlaneCodec::encode_step(std::size_t k) {
    RefinedHeights& out = slots_[static_cast<std::size_t>(plan_.steps[k].slot)];
    scratch_.statistics = statistics_.get();
    if (absent_side(plan_.steps[k]) < 0)
        return kernel_.encode(p_, reference_of(k, Order::four), out, scratch_);
    EncodedResiduals best;
    RefinedHeights trial;
    bool first = true;
    for (const Order o : {Order::four, Order::six, Order::two}) {
        const unsigned bit = 1u << static_cast<unsigned>(o);
        if ((kernel_.choice().coding.orders & bit) == 0) continue;
        EncodedResiduals e = kernel_.encode_with(bit, p_, reference_of(k, o), trial, scratch_);
        if (!first && e.blob.size() >= best.blob.size()) continue;
        best = std::move(e);
        std::swap(out, trial);
        first = false;
    }
    return best;
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

void PlaneCodec::store_leaf(const PlaneStep& step, Raster& out) const {
    const PixelFrame& f = step.frame;
    const bool i_along_x = f.ux != 0;
    const int x_sign = i_along_x ? f.ux : f.vx, y_sign = i_along_x ? f.vy : f.uy;
    const int x_stride = (i_along_x ? kN : 1) * x_sign, y_stride = (i_along_x ? 1 : kN) * y_sign;
    const int left = x_sign > 0 ? f.x / 2 : f.x / 2 - kCells, top = y_sign > 0 ? f.y / 2 : f.y / 2 - kCells;
    const int width = std::min(kN, out.width - left), height = std::min(kN, out.height - top);
    for (int y = 0; y < height; ++y) {
        const std::int32_t* from = p_.data() + (x_sign > 0 ? 0 : -kCells * x_stride) +
                                   (y_sign > 0 ? 0 : -kCells * y_stride) + y * y_stride;
        const std::ptrdiff_t to = static_cast<std::ptrdiff_t>(top + y) * out.width + left;
        if (out.integer)
            for (int x = 0; x < width; ++x)
                out.whole[static_cast<std::size_t>(to + x)] = static_cast<std::int16_t>(from[x * x_stride]);
        else
            for (int x = 0; x < width; ++x)
                out.real[static_cast<std::size_t>(to + x)] =
                    static_cast<float>(from[x * x_stride] * quantum_);
    }
}

void PlaneCodec::decode(Raster& out) {
    cycles_ = {};
    for (std::size_t k = 0; k < plan_.steps.size(); ++k) {
        const PlaneStep& step = plan_.steps[k];
        const std::uint64_t t0 = cycles_now();
        assemble(step);
        const std::uint64_t t1 = cycles_now();
        cycles_.gather += t1 - t0;
        if (step.slot < 0) {
            store_leaf(step, out);
            cycles_.store += cycles_now() - t1;
            continue;
        }
        const Coded& c = coded_[k];
        kernel_.decode(c.info, std::span(blobs_).subspan(c.offset, c.bytes), p_, kN,
                       slots_[static_cast<std::size_t>(step.slot)], scratch_);
        cycles_.kernel += cycles_now() - t1;
    }
}

}  // namespace carat::bench
