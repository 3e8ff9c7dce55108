#include "carat/bench/triangles.hpp"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "carat/bench/random_views.hpp"
#include "carat/globe/bounds.hpp"
#include "carat/render/draw_list.hpp"
#include "carat/render/vector.hpp"
#include "exact_error.hpp"
#include "part_distances.hpp"

namespace carat::bench {
namespace {

constexpr std::size_t kMost = 20'000;  // diamonds refined by a metric that knows no relief

class ViewMeasure {
  public:
    ViewMeasure(const std::shared_ptr<const Repository>& file, const View& view, double threshold,
                HalfPositions& positions, PartDistances& distances)
        : file_(file),
          threshold_(threshold),
          body_(file->header().ellipsoid()),
          cells_(file->header().cells()),
          visibility_(view, body_, file->header().min_height * file->header().quantum,
                      file->header().max_height * file->header().quantum, threshold),
          exact_(file, visibility_, positions),
          rounding_(HalfSurvey(*file, body_).rounding()),
          distances_(distances) {}

    TrianglesRow run() {
        TrianglesRow row;
        const Cut cut = select_cut(*file_, visibility_, threshold_);
        row.ours = cut.counters.triangles;
        for (const FrontierHalf& h : cut.frontier)
            if (h.culled == Culled::none && exact_.refined({h.half, h.half}))
                row.error = exact_.greatest({h.half, h.half}, Measure::distance, row.error, false);
        row.distance = oracle(Measure::distance);
        row.shift = oracle(Measure::shift);
        row.exact_delta = bounded(Parts::whole);
        row.exact_quarters = bounded(Parts::quarters);
        const Spacing paper = [this](const FreeHalf& h) { return by_size(h); };
        row.paper_plain = by_spacing(paper, std::sqrt(2.0));  // two triangles a cell
        if (const auto plain = cut_by(paper, std::sqrt(2.0)))
            for (const FreeHalf& h : *plain)
                if (exact_.refined(h) && drawn(h))
                    row.paper_plain.error =
                        exact_.greatest(h, Measure::distance, row.paper_plain.error, false);
        row.paper = at_equal_error(paper, row.error);
        row.nearness = at_equal_error([this](const FreeHalf& h) { return by_distance(h); }, row.error);
        return row;
    }

  private:
    using Spacing = std::function<double(const FreeHalf&)>;  // pixels

    bool drawn(const FreeHalf& h) { return visibility_.cull(exact_.volume(h, kMargin)) == Culled::none; }

    std::uint64_t triangles(const std::vector<FreeHalf>& frontier) {
        const auto count =
            std::count_if(frontier.begin(), frontier.end(), [this](const FreeHalf& h) { return drawn(h); });
        return static_cast<std::uint64_t>(count) * static_cast<std::uint64_t>(cells_) *
               static_cast<std::uint64_t>(cells_);
    }

    std::uint64_t oracle(Measure measure) {
        const auto demands = [&](const FreeHalf& h) {
            return drawn(h) && exact_.greatest(h, measure, threshold_, true) > threshold_;
        };
        return triangles(least_cut(*file_, demands, kMaxRefined).value());
    }

    std::uint64_t bounded(Parts parts) {
        const auto demands = [&](const FreeHalf& h) {
            if (!drawn(h)) return false;
            if (!exact_.refined(h)) return exact_.greatest(h, Measure::distance, 0, true) > threshold_;
            return bound_by_parts(*file_, visibility_, h.half, parts, rounding_, distances_) > threshold_;
        };
        return triangles(least_cut(*file_, demands, kMaxRefined).value());
    }

    // (a) The paper's: how large the triangles are on the screen, at the nearest point of the half's volume.
    double by_size(const FreeHalf& h) {
        return visibility_.screen_spacing(exact_.volume(h, kMargin), spacing_of(h.half.diamond));
    }
    // (b) From the eye to the middle of the half on the ellipsoid; the size is that of its level.
    double by_distance(const FreeHalf& h) {
        const HalfFrame f = half_frame(h.half, 4);
        const Vec3 middle = body_.position(direction(h.half.side == 0 ? f.vertex(3, 1) : f.vertex(1, 3)), 0);
        const double size = body_.a() * std::exp2(-0.5 * h.half.diamond.level()) / cells_;
        return visibility_.view().focal_pixels() * size / length(subtract(middle, visibility_.view().eye()));
    }
    double spacing_of(DiamondId d) {
        const auto [at, is_new] = spacings_.try_emplace(d, 0.0);
        if (is_new) at->second = sample_spacing(body_, d, cells_);
        return at->second;
    }

    std::optional<std::vector<FreeHalf>> cut_by(const Spacing& spacing, double limit) {
        return least_cut(
            *file_, [&](const FreeHalf& h) { return exact_.refined(h) && spacing(h) > limit && drawn(h); },
            kMost);
    }

    SpacingCut by_spacing(const Spacing& spacing, double limit) {
        const auto cut = cut_by(spacing, limit);
        return {limit, cut ? triangles(*cut) : 0, 0};
    }

    bool within(const std::vector<FreeHalf>& frontier, double error) {
        return std::none_of(frontier.begin(), frontier.end(), [&](const FreeHalf& h) {
            return exact_.refined(h) && drawn(h) &&
                   exact_.greatest(h, Measure::distance, error, true) > error;
        });
    }

    // The greatest limit that keeps the error, within a tenth. These metrics have nothing to refine below the
    // leaves, and what the sagitta is there is not held against them.
    SpacingCut at_equal_error(const Spacing& spacing, double error) {
        double good = 0, bad = 64;
        for (double limit = bad / 2; good == 0; limit /= 2) {
            const auto cut = cut_by(spacing, limit);
            if (!cut) return {};
            (within(*cut, error) ? good : bad) = limit;
        }
        while (bad / good > 1.1) {
            const double limit = std::sqrt(good * bad);
            const auto cut = cut_by(spacing, limit);
            (cut && within(*cut, error) ? good : bad) = limit;
        }
        SpacingCut out = by_spacing(spacing, good);
        out.error = error;
        return out;
    }

    static constexpr double kMargin = 1e-4;  // metres

    const std::shared_ptr<const Repository> file_;
    const double threshold_;
    const Ellipsoid body_;
    const int cells_;
    const Visibility visibility_;
    ExactError exact_;
    const double rounding_;
    PartDistances& distances_;
    std::unordered_map<DiamondId, double, DiamondIdHash> spacings_;
};

const char* manner(int k) {
    constexpr const char* kNames[] = {"globe", "oblique", "grazing", "ground"};
    return kNames[k / 2 % 4];
}

}  // namespace

std::vector<TrianglesRow> measure_triangles(const std::shared_ptr<const Repository>& file,
                                            const TrianglesOptions& o) {
    RandomViews views(file, o.seed, o.width, o.height, o.place);
    HalfPositions positions(file);
    PartDistances distances(*file, positions);
    const Ellipsoid body = file->header().ellipsoid();
    std::vector<TrianglesRow> rows;
    for (int k = 0; k < o.views; ++k) {
        if (o.progress && !o.progress(rows.size(), static_cast<std::size_t>(o.views))) break;
        rows.push_back(ViewMeasure(file, View(body, views.next()), o.threshold, positions, distances).run());
        rows.back().view = manner(k);
    }
    return rows;
}

}  // namespace carat::bench
