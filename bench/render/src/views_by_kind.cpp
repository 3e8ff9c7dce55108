#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "carat/bench/random_views.hpp"
#include "carat/bench/screen_evidence.hpp"
#include "carat/globe/locate.hpp"

namespace carat::bench {
namespace {

using Manner = RandomViews::Manner;

Geodetic corner(int k) {
    constexpr double kLatitude = 35.26438968275465;  // atan(1/sqrt(2))
    return {k / 4 % 2 == 0 ? kLatitude : -kLatitude, 45.0 + 90 * (k % 4) - 180};
}

// Along the steepest of eight neighbours a sample away, to where there is none lower.
Geodetic downhill(const Surface& surface, Geodetic at) {
    const double a = surface.repository().header().ellipsoid().a();
    Surface::Sample lowest = surface.sample(lattice_position(direction(at)));
    for (int k = 0; k < 1000; ++k) {
        const double step = lowest.spacing / a * 180 / std::numbers::pi;
        const Geodetic from = at;
        for (int e = -1; e <= 1; ++e)
            for (int n = -1; n <= 1; ++n) {
                const Geodetic there{std::clamp(from.latitude + n * step, -90.0, 90.0),
                                     std::remainder(from.longitude + e * step, 360.0)};
                const Surface::Sample s = surface.sample(lattice_position(direction(there)));
                if (!(s.height < lowest.height)) continue;
                lowest = s;
                at = there;
            }
        if (at.latitude == from.latitude && at.longitude == from.longitude) break;
    }
    return at;
}

// From all manners in turn.
ViewRequest near(RandomViews& views, const Geodetic& at, int turn) {
    const Geodetic place = views.around(at, views.factor(1e-6, 1));
    return views.from(place, static_cast<Manner>(turn % 4));
}

}  // namespace

std::vector<KindOfView> views_by_kind(const std::shared_ptr<const Repository>& file, int count, unsigned seed,
                                      int width, int height, const Geodetic& place) {
    RandomViews views(file, seed, width, height);
    std::vector<KindOfView> out;
    const auto add = [&](const char* kind, const ViewRequest& view) {
        if (static_cast<int>(out.size()) < count) out.push_back({kind, view});
    };
    for (int turn = 0; static_cast<int>(out.size()) < count; ++turn) {
        add("orbit", views.from(views.around(place, 20), Manner::globe));
        add("oblique", views.from(views.around(place, 1), Manner::oblique));
        add("grazing", views.from(views.around(place, 1), Manner::grazing));
        ViewRequest valley = views.from(downhill(views.surface(), views.around(place, 0.5)), Manner::ground);
        valley.pitch = views.share(-20, 20);
        add("valley floor", valley);
        add("pole", near(views, {turn % 2 == 0 ? 90.0 : -90.0, 0}, turn / 2));
        add("cube corner", near(views, corner(turn), turn));
        add("antimeridian", near(views, {views.share(-80, 80), 180}, turn));
    }
    return out;
}

}  // namespace carat::bench
