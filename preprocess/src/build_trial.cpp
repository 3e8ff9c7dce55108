#include "build_trial.hpp"

#include <algorithm>
#include <cmath>

#include "carat/codec/heights.hpp"
#include "carat/codec/quantize.hpp"
#include "carat/globe/patch.hpp"

namespace carat {
namespace {

// Work space of one thread: many trials may wait for their turn.
struct Scratch {
    CodecScratch codec;
    std::vector<double> heights;
    std::vector<std::int32_t> p;
    RefinedHeights refined;

    static Scratch& of_thread() {
        thread_local Scratch scratch;
        return scratch;
    }
};

double squares(const std::vector<std::int32_t>& a, const std::vector<std::int32_t>& b) {
    double sum = 0;
    for (std::size_t k = 0; k < a.size(); ++k) {
        const double e = static_cast<double>(a[k]) - b[k];
        sum += e * e;
    }
    return sum;
}

}  // namespace

std::vector<DiamondId> spread_diamonds(const RefinedLevels& levels, std::size_t most) {
    std::vector<DiamondId> all;
    for (const auto& level : levels) all.insert(all.end(), level.begin(), level.end());
    std::vector<DiamondId> out(std::min(most, all.size()));
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = all[(2 * k + 1) * all.size() / (2 * out.size())];
    return out;
}

Trial::Trial(const BuildOptions& options, const SourceStack& sources)
    : options_(options),
      sources_(sources),
      n_((1 << options.log2_cells) + 1),
      quantum_(options.quantum.value_or(default_quantum(options.tolerance))) {}

void Trial::take(DiamondId d) {
    reference_.n = n_;
    reference_.v.resize(static_cast<std::size_t>(n_ * n_));
    reference_.c.resize(static_cast<std::size_t>((n_ - 1) * (n_ - 1)));
    for (const int side : {0, 1})
        for (const Half& child : child_halves({d, side})) take_half(child, d);
}

void Trial::take_half(const Half& half, DiamondId d) {
    std::vector<double>& heights = Scratch::of_thread().heights;
    heights.resize(half_vertex_count(n_ - 1));
    sources_.sample(half, n_ - 1, heights);
    const ChildMap m = child_map(d, half, n_ - 1);
    const double* next = heights.data();
    for (int i = 0; i < n_; ++i)
        for (int j = half.side == 0 ? 0 : i; j < (half.side == 0 ? i + 1 : n_); ++j) {
            const int p = m.p0 + i * m.pi + j * m.pj, q = m.q0 + i * m.qi + j * m.qj;
            const double scaled =
                std::clamp(*next++ / quantum_, -1.0 * kGreatestHeight, 1.0 * kGreatestHeight);
            auto& to = (p & 1) == 0 ? reference_.v[static_cast<std::size_t>((p >> 1) * n_ + (q >> 1))]
                                    : reference_.c[static_cast<std::size_t>((p >> 1) * (n_ - 1) + (q >> 1))];
            to = static_cast<std::int32_t>(std::lround(scaled));
        }
}

Trial::Result Trial::code(const Coding& coding, std::int32_t radius, RangeStatistics* statistics) {
    Scratch& w = Scratch::of_thread();
    const double step = 2.0 * radius + 1;
    w.p.resize(reference_.v.size());
    for (std::size_t k = 0; k < w.p.size(); ++k)
        w.p[k] = static_cast<std::int32_t>(step * std::round(static_cast<double>(reference_.v[k]) / step));
    w.codec.statistics = statistics;
    Result out;
    out.bytes =
        encode_residuals(coding, options_.mode, w.p, reference_, radius, w.refined, w.codec).blob.size();
    out.squares = squares(reference_.c, w.refined.c);
    out.values = reference_.c.size();
    if (options_.mode != Mode::interpolating) {
        out.squares += squares(reference_.v, w.refined.v);
        out.values += reference_.v.size();
    }
    return out;
}

}  // namespace carat
