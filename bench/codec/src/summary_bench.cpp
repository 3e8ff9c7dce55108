#include "carat/bench/summary_bench.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>
#include <unordered_set>

#include "carat/codec/surface.hpp"
#include "carat/globe/error.hpp"
#include "carat/globe/patch.hpp"
#include "carat/globe/sphere.hpp"

namespace carat::bench {
namespace {

double distance(const Vec3& a, const Vec3& b) {
    double s = 0;
    for (std::size_t k = 0; k < 3; ++k) s += (a[k] - b[k]) * (a[k] - b[k]);
    return std::sqrt(s);
}

template <class Visit>
void for_half(int n, int side, Visit visit) {
    for (int i = 0; i < n; ++i)
        for (int j = side == 0 ? 0 : i; j < (side == 0 ? i + 1 : n); ++j) visit(i, j);
}

struct Exact {
    double delta = 0;
    double least = std::numeric_limits<double>::infinity(),
           greatest = -std::numeric_limits<double>::infinity();
};

class HalfMeasure {
  public:
    HalfMeasure(const Surface& surface, const Half& half)
        : surface_(surface),
          body_(surface.repository().header().ellipsoid()),
          quantum_(surface.repository().header().quantum),
          n_(surface.repository().header().n()),
          frame_(half_frame(half, n_ - 1)),
          flat_(positions(half)) {
        visit(half);
    }
    const Exact& exact() const { return exact_; }

  private:
    std::vector<Vec3> positions(const Half& half) const {
        const auto p = surface_.heights(half.diamond);
        const HalfFrame f = half_frame(half, n_ - 1);
        std::vector<Vec3> out(static_cast<std::size_t>(n_ * n_));
        for_half(n_, half.side, [&](int i, int j) {
            out[static_cast<std::size_t>(i * n_ + j)] =
                body_.position(direction(f.vertex(i, j)), p->at(i, j) * quantum_);
        });
        return out;
    }

    void visit(const Half& g) {
        if (surface_.repository().refined(g.diamond)) {
            for (const Half& child : child_halves(g)) visit(child);
            return;
        }
        const auto p = surface_.heights(g.diamond);
        const HalfFrame f = half_frame(g, n_ - 1);
        for_half(n_, g.side, [&](int i, int j) {
            const double h = p->at(i, j) * quantum_;
            const LatticePoint at = f.vertex(i, j);
            exact_.least = std::min(exact_.least, h);
            exact_.greatest = std::max(exact_.greatest, h);
            exact_.delta = std::max(exact_.delta, distance(flat_point(at), body_.position(direction(at), h)));
        });
    }

    // The flat patch at a lattice point below the half: the axes of a frame are orthogonal.
    Vec3 flat_point(const LatticePoint& at) const {
        const LatticeVector d = wide(at) - frame_.origin;
        const auto along = [&](const LatticeVector& axis) {
            double product = 0, square = 0;
            for (int k = 0; k < 3; ++k) {
                product += static_cast<double>(d[k]) * static_cast<double>(axis[k]);
                square += static_cast<double>(axis[k]) * static_cast<double>(axis[k]);
            }
            return product / square;
        };
        const TriangleWeights w = triangle_weights(along(frame_.u), along(frame_.v), n_ - 1);
        Vec3 out{};
        for (std::size_t k = 0; k < 3; ++k) {
            const Vec3& corner = flat_[static_cast<std::size_t>(w.vertex[k][0] * n_ + w.vertex[k][1])];
            for (std::size_t a = 0; a < 3; ++a) out[a] += w.weight[k] * corner[a];
        }
        return out;
    }

    const Surface& surface_;
    Ellipsoid body_;
    double quantum_;
    int n_;
    HalfFrame frame_;
    std::vector<Vec3> flat_;
    Exact exact_;
};

double median(std::vector<double> x) {
    if (x.empty()) return 0;
    std::nth_element(x.begin(), x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2), x.end());
    return x[x.size() / 2];
}

std::vector<std::vector<DiamondId>> refined_levels(const Repository& file) {
    std::vector<std::vector<DiamondId>> levels;
    std::vector<DiamondId> level;
    for (int face = 0; face < kFaces; ++face)
        if (file.refined(root_diamond(face))) level.push_back(root_diamond(face));
    while (!level.empty()) {
        levels.push_back(level);
        std::unordered_set<DiamondId, DiamondIdHash> next;
        for (const DiamondId d : level)
            for (const DiamondId child : children(d))
                if (file.refined(child)) next.insert(child);
        level.assign(next.begin(), next.end());
        std::sort(level.begin(), level.end());
    }
    return levels;
}

// Leaf halves below, without looking at heights.
class LeafCounter {
  public:
    explicit LeafCounter(const Repository& file) : file_(file) {}
    std::size_t operator()(const Half& h) {
        if (!file_.refined(h.diamond)) return 1;
        if (const auto known = known_.find(h); known != known_.end()) return known->second;
        std::size_t count = 0;
        for (const Half& child : child_halves(h)) count += (*this)(child);
        return known_[h] = count;
    }

  private:
    const Repository& file_;
    std::unordered_map<Half, std::size_t, HalfHash> known_;
};

// Halves evenly spread over the level until their leaves hold so many vertices.
std::vector<Half> choose(const std::vector<DiamondId>& level, std::size_t vertices, int n,
                         LeafCounter& leaves) {
    std::size_t total = 0;
    for (const DiamondId d : level) total += leaves({d, 0}) + leaves({d, 1});
    const std::size_t each = half_vertex_count(n - 1);
    const std::size_t stride = std::max<std::size_t>(1, total * each / vertices);
    std::vector<Half> out;
    for (std::size_t k = 0; k < 2 * level.size(); k += stride)
        out.push_back({level[k / 2], static_cast<int>(k % 2)});
    return out;
}

double spacing(const Half& half, const Ellipsoid& body, int n) {
    const HalfFrame f = half_frame(half, n - 1);
    const int i = half.side == 0 ? n / 2 : n / 4, j = half.side == 0 ? n / 4 : n / 2;
    return distance(body.position(direction(f.vertex(i, j)), 0),
                    body.position(direction(f.vertex(i + 1, j)), 0));
}

}  // namespace

std::vector<SummaryRow> bench_summaries(const std::shared_ptr<const Repository>& file,
                                        const SummaryBenchOptions& options) {
    const RepositoryHeader& header = file->header();
    const Surface surface(file, std::size_t{512} << 20);
    const auto levels = refined_levels(*file);
    LeafCounter leaves(*file);
    std::vector<SummaryRow> rows;
    for (std::size_t l = 0; l < levels.size(); ++l) {
        SummaryRow row;
        row.level = static_cast<int>(l);
        row.refined = 2 * levels[l].size();
        std::vector<double> ratio, exact, ranges, spacings;
        for (const Half& half : choose(levels[l], options.vertices_per_level, header.n(), leaves)) {
            if (options.progress && !options.progress(l, levels.size()))
                throw Error(ErrorCode::usage, "cancelled");
            const Exact e = HalfMeasure(surface, half).exact();
            const HalfSummary s = file->summary(half);
            ++row.halves;
            if (s.delta < e.delta || s.min_height > e.least || s.max_height < e.greatest) ++row.violations;
            exact.push_back(e.delta);
            spacings.push_back(spacing(half, header.ellipsoid(), header.n()));
            if (e.delta > 0) ratio.push_back(s.delta / e.delta);
            if (e.greatest > e.least)
                ranges.push_back((s.max_height - s.min_height) / (e.greatest - e.least));
        }
        if (!ratio.empty()) {
            row.least = *std::min_element(ratio.begin(), ratio.end());
            row.greatest = *std::max_element(ratio.begin(), ratio.end());
        }
        row.median = median(ratio);
        row.exact = median(exact);
        row.spacing = median(spacings);
        row.range_median = median(ranges);
        rows.push_back(row);
    }
    return rows;
}

}  // namespace carat::bench
