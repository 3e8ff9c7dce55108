#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>

#include "carat/bench/screen_evidence.hpp"
#include "carat/globe/locate.hpp"

namespace carat::bench {
namespace {

constexpr double kDegree = std::numbers::pi / 180;

class Views {
  public:
    Views(const std::shared_ptr<const Repository>& file, unsigned seed, const Geodetic& place)
        : surface_(file), body_(file->header().ellipsoid()), random_(seed), place_(place) {}

    KindOfView next(int k) {
        constexpr std::array<const char*, 7> kKinds{"orbit", "oblique",     "grazing",     "valley floor",
                                                    "pole",  "cube corner", "antimeridian"};
        const auto kind = static_cast<std::size_t>(k) % kKinds.size();
        const int turn = k / static_cast<int>(kKinds.size());
        switch (kind) {
            case 3:
                return {kKinds[kind], from(downhill(around(place_, 0.5)), 3)};
            case 4:
                return {kKinds[kind],
                        from(around({turn % 2 == 0 ? 90.0 : -90.0, 0}, nearness()), turn / 2 % 4)};
            case 5:
                return {kKinds[kind], from(around(corner(turn), nearness()), turn % 4)};
            case 6:
                return {kKinds[kind], from(around({share(-80, 80), 180}, nearness()), turn % 4)};
            default:
                return {kKinds[kind], from(around(place_, kind == 0 ? 20 : 1), static_cast<int>(kind))};
        }
    }

  private:
    double share(double low, double high) {
        return std::uniform_real_distribution<double>(low, high)(random_);
    }
    double factor(double low, double high) { return std::exp(share(std::log(low), std::log(high))); }
    double nearness() { return factor(1e-6, 1); }  // degrees
    double ground(const Geodetic& at) const {
        return surface_.sample(lattice_position(direction(at))).height;
    }

    static Geodetic corner(int k) {
        constexpr double kLatitude = 35.26438968275465;  // atan(1/sqrt(2))
        return {k / 4 % 2 == 0 ? kLatitude : -kLatitude, 45.0 + 90 * (k % 4) - 180};
    }
    Geodetic around(const Geodetic& at, double degrees) {
        return {std::clamp(at.latitude + degrees * share(-1, 1), -90.0, 90.0),
                std::remainder(at.longitude + degrees * share(-1, 1), 360.0)};
    }

    // Along the steepest of eight neighbours a sample away, to where there is none lower.
    Geodetic downhill(Geodetic at) const {
        double height = ground(at);
        for (int k = 0; k < 1000; ++k) {
            const double step =
                surface_.sample(lattice_position(direction(at))).spacing / body_.a() / kDegree;
            Geodetic lowest = at;
            for (int e = -1; e <= 1; ++e)
                for (int n = -1; n <= 1; ++n) {
                    const Geodetic there{std::clamp(at.latitude + n * step, -90.0, 90.0),
                                         std::remainder(at.longitude + e * step, 360.0)};
                    if (const double h = ground(there); h < height) {
                        height = h;
                        lowest = there;
                    }
                }
            if (lowest.latitude == at.latitude && lowest.longitude == at.longitude) break;
            at = lowest;
        }
        return at;
    }

    // height: 0 from orbit, 1 oblique, 2 grazing, 3 near the ground.
    ViewRequest from(const Geodetic& at, int height) {
        ViewRequest r;
        r.eye = at;
        r.heading = share(0, 360);
        r.fov = share(20, 80);
        const double size = body_.a() / 6.4e6;
        double over = 0;
        switch (height) {
            case 0:
                over = size * factor(1e5, 1e8);
                r.pitch = -90 + share(0, 0.9) * std::asin(body_.b() / (body_.a() + over)) / kDegree;
                break;
            case 1:
                over = size * factor(1e3, 1e5);
                r.pitch = share(-80, -10);
                break;
            case 2:
                over = factor(20, 2000);
                r.pitch = share(-12, 3);
                break;
            default:
                over = factor(2, 30);
                r.pitch = share(-20, 20);
        }
        r.height = ground(at) + over;
        return r;
    }

    Surface surface_;
    Ellipsoid body_;
    std::mt19937_64 random_;
    Geodetic place_;
};

}  // namespace

std::vector<KindOfView> views_by_kind(const std::shared_ptr<const Repository>& file, int count, unsigned seed,
                                      int width, int height, const Geodetic& place) {
    Views views(file, seed, place);
    std::vector<KindOfView> out;
    for (int k = 0; k < count; ++k) {
        out.push_back(views.next(k));
        out.back().view.width = width;
        out.back().view.image_height = height;
    }
    return out;
}

}  // namespace carat::bench
