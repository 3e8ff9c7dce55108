#include "carat/bench/detail_spectrum.hpp"

#include <algorithm>
#include <bit>
#include <chrono>
#include <cmath>
#include <ctime>
#include <map>
#include <numbers>
#include <random>

#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/locate.hpp"
#include "carat/globe/patch.hpp"
#include "carat/render/detail_surface.hpp"

namespace carat::bench {
namespace {

constexpr int kFiner = 16;  // samples of a profile a spacing of the leaf

double thread_seconds() {
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

RealLattice real(const LatticePoint& p) {
    return {face_of(p), {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)}};
}

// Leaves with both halves in the file, drawn at random places.
std::vector<DiamondId> draw_leaves(const Repository& repository, const DetailBenchOptions& o) {
    std::mt19937_64 generator(o.seed);
    const auto b = o.bounds.value_or(std::array<double, 4>{-180, -90, 180, 90});
    const auto sine = [](double degrees) { return std::sin(degrees * std::numbers::pi / 180); };
    std::uniform_real_distribution<double> longitude(b[0], b[2]), z(sine(b[1]), sine(b[3]));
    std::vector<DiamondId> out;
    for (int k = 0; k < 100 * o.leaves && out.size() < static_cast<std::size_t>(o.leaves); ++k) {
        const Geodetic place{std::asin(z(generator)) * 180 / std::numbers::pi, longitude(generator)};
        const DiamondId d = leaf_half(repository, lattice_position(direction(place))).diamond;
        const int level = d.level();
        if (level < 1 || level > 38) continue;
        if (repository.refined(*parent(d, 0)) && repository.refined(*parent(d, 1))) out.push_back(d);
    }
    if (out.empty()) throw Error(ErrorCode::usage, "no whole leaf of the file lies within the bounds");
    // Those of the level that most are of.
    std::map<int, int> levels;
    for (const DiamondId d : out) ++levels[d.level()];
    const int level = std::max_element(levels.begin(), levels.end(), [](const auto& l, const auto& r) {
                          return l.second < r.second;
                      })->first;
    std::erase_if(out, [level](DiamondId d) { return d.level() != level; });
    return out;
}

// Power of a profile at k cycles over its length, its trend taken away, under Hann's window.
class Periodogram {
  public:
    explicit Periodogram(int n) : cosine_(static_cast<std::size_t>(n)), window_(static_cast<std::size_t>(n)) {
        double square = 0;
        for (int k = 0; k < n; ++k) {
            cosine_[static_cast<std::size_t>(k)] = std::cos(2 * std::numbers::pi * k / n);
            const double w = 0.5 - 0.5 * std::cos(2 * std::numbers::pi * (k + 0.5) / n);
            window_[static_cast<std::size_t>(k)] = w;
            square += w * w;
        }
        norm_ = 1 / square;
    }

    void add(std::vector<double> h, std::vector<double>& power) const {
        const std::size_t n = cosine_.size(), quarter = n / 4;
        double mean = 0, slope = 0, square = 0;
        const double middle = static_cast<double>(n - 1) / 2;
        for (std::size_t k = 0; k < n; ++k) {
            const double x = static_cast<double>(k) - middle;
            mean += h[k];
            slope += x * h[k];
            square += x * x;
        }
        mean /= static_cast<double>(n);
        slope /= square;
        for (std::size_t k = 0; k < n; ++k)
            h[k] = (h[k] - mean - slope * (static_cast<double>(k) - middle)) * window_[k];
        for (std::size_t f = 1; f < power.size(); ++f) {
            double re = 0, im = 0;
            for (std::size_t k = 0, phase = 0; k < n; ++k, phase = (phase + f) & (n - 1)) {
                re += h[k] * cosine_[phase];
                im += h[k] * cosine_[(phase + quarter) & (n - 1)];
            }
            power[f] += (re * re + im * im) * norm_;
        }
    }

  private:
    std::vector<double> cosine_, window_;
    double norm_ = 0;
};

// Least squares of log power over log wavelength; y = slope x + offset.
struct Line {
    double slope = 0, offset = 0;
};
Line fit(const std::vector<SpectrumRow>& rows, double from, double to, double SpectrumRow::*power) {
    double n = 0, sx = 0, sy = 0, sxx = 0, sxy = 0;
    for (const SpectrumRow& r : rows) {
        if (r.wavelength > from || r.wavelength < to || !(r.*power > 0)) continue;
        const double x = std::log(r.wavelength), y = std::log(r.*power);
        n += 1, sx += x, sy += y, sxx += x * x, sxy += x * y;
    }
    if (n < 2) return {};
    const double slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
    return {slope, (sy - slope * sx) / n};
}

std::vector<SpectrumRow> by_thirds(const std::vector<double>& before, const std::vector<double>& after,
                                   int cells, double profiles) {
    std::vector<SpectrumRow> rows;
    for (double low = 1; low < static_cast<double>(before.size()); low *= std::cbrt(2.0)) {
        const double high = low * std::cbrt(2.0);
        SpectrumRow row;
        double count = 0, log = 0;
        for (auto f = static_cast<std::size_t>(std::ceil(low));
             static_cast<double>(f) < high && f < before.size(); ++f) {
            row.before += before[f];
            row.after += after[f];
            log += std::log(static_cast<double>(f));
            ++count;
        }
        if (count == 0) continue;
        row.wavelength = cells / std::exp(log / count);
        row.before /= count * profiles * kFiner;
        row.after /= count * profiles * kFiner;
        rows.push_back(row);
    }
    return rows;
}

void measure_spectrum(const std::shared_ptr<const Repository>& repository, const DetailBenchOptions& o,
                      const std::vector<DiamondId>& leaves, DetailSpectrum& out) {
    const int cells = repository->header().cells(), n = cells * kFiner;
    const Surface plain(repository);
    // Finer than the samples of a profile there is no need to go.
    DetailOptions options = o.detail;
    const Detail whole(repository->header(), options);
    const auto finest =
        static_cast<std::size_t>(leaves[0].level()) + 2 * std::countr_zero(unsigned{kFiner}) + 1;
    options.to =
        std::max(options.to, 1.01 * whole.spacing(static_cast<int>(std::min<std::size_t>(finest, 49))));
    const DetailSurface detailed(repository, std::make_shared<const Detail>(repository->header(), options));
    const Periodogram periodogram(n);
    std::vector<double> before(static_cast<std::size_t>(n / 2)), after(before.size());
    std::vector<double> h(static_cast<std::size_t>(n)), d(h.size());
    for (const DiamondId leaf : leaves)
        for (const int row : {cells / 4, cells * 5 / 8}) {
            // Row `row` of the whole diamond: half 0 up to the diagonal, then half 1.
            const HalfFrame f0 = half_frame({leaf, 0}, n), f1 = half_frame({leaf, 1}, n);
            for (int k = 0; k < n; ++k) {
                const int i = row * kFiner;
                const RealLattice p = real(k <= i ? f0.vertex(i, k) : f1.vertex(i, k));
                h[static_cast<std::size_t>(k)] = plain.sample(p).height;
                d[static_cast<std::size_t>(k)] = detailed.sample(p).height;
            }
            periodogram.add(h, before);
            periodogram.add(d, after);
            ++out.profiles;
        }
    out.rows = by_thirds(before, after, cells, static_cast<double>(out.profiles));
    const Line data = fit(out.rows, 32, 4, &SpectrumRow::before);
    out.data_slope = data.slope;
    out.before_slope = fit(out.rows, 1, 0.25, &SpectrumRow::before).slope;
    out.detail_slope = fit(out.rows, 1, 0.25, &SpectrumRow::after).slope;
    double log = 0, count = 0;
    for (const SpectrumRow& r : out.rows) {
        if (r.wavelength > 1 || r.wavelength < 0.25) continue;
        log += std::log(r.after) - (data.slope * std::log(r.wavelength) + data.offset);
        ++count;
    }
    out.continued = std::exp(log / std::max(count, 1.0));
}

void measure_rates(const std::shared_ptr<const Repository>& repository, const DetailBenchOptions& o,
                   const std::vector<DiamondId>& leaves, DetailSpectrum& out) {
    const int cells = repository->header().cells();
    const Surface surface(repository);
    const Detail detail(repository->header(), o.detail);
    struct Work {
        DiamondId parent, leaf;
        int level = 0;
        Heights heights;
        std::array<HalfHeights, 2> halves;
    };
    std::vector<Work> works;
    for (const DiamondId leaf : leaves) {
        Work w{*parent(leaf, 0), leaf, leaf.level(), {}, {}};
        if (w.level >= detail.end_level()) continue;
        w.heights = *surface.heights(w.parent);
        for (const int side : {0, 1}) {
            const DiamondId up = *parent(leaf, side);
            HalfHeights& half = w.halves[static_cast<std::size_t>(side)];
            half = gather_child(*surface.refined_heights(up), up, {leaf, side});
            detail.begin(*repository, {leaf, side}, half);
        }
        works.push_back(std::move(w));
    }
    const auto children = [&](const auto& refined, DiamondId d) {
        std::size_t sum = 0;
        for (const int side : {0, 1})
            for (const Half& child : child_halves({d, side})) sum += gather_child(refined, d, child).size();
        return sum;
    };
    const double samples = static_cast<double>(works.size()) * cells * cells;
    for (int round = 0; round < o.rounds; ++round) {
        std::size_t sum = 0;
        RefinedHeights refined;
        VirtualHeights synthesised;
        const double begin = thread_seconds();
        for (const Work& w : works) {
            repository->refine(w.parent, w.heights, refined);
            sum += children(refined, w.parent);
        }
        const double decoded = thread_seconds();
        for (const Work& w : works) {
            detail.refine(w.leaf, w.level, w.halves[0], w.halves[1], synthesised);
            sum += children(synthesised, w.leaf);
        }
        const double end = thread_seconds();
        if (sum == 0) continue;
        out.decoded_per_second = std::max(out.decoded_per_second, samples / (decoded - begin));
        out.synthesised_per_second = std::max(out.synthesised_per_second, samples / (end - decoded));
    }
}

}  // namespace

DetailSpectrum measure_detail(const std::shared_ptr<const Repository>& repository,
                              const DetailBenchOptions& options) {
    DetailSpectrum out;
    const std::vector<DiamondId> leaves = draw_leaves(*repository, options);
    out.leaves = leaves.size();
    measure_spectrum(repository, options, leaves, out);
    measure_rates(repository, options, leaves, out);
    return out;
}

}  // namespace carat::bench
