#include "carat/bench/random_views.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "carat/globe/locate.hpp"

namespace carat::bench {

RandomViews::RandomViews(std::shared_ptr<const Repository> repository, unsigned seed, int width, int height,
                         const std::optional<Geodetic>& place)
    : surface_(repository, 64u << 20),
      body_(repository->header().ellipsoid()),
      random_(seed),
      width_(width),
      height_(height),
      place_(place) {}

double RandomViews::share(double from, double to) {
    return std::uniform_real_distribution<double>(from, to)(random_);
}

double RandomViews::factor(double from, double to) { return std::exp(share(std::log(from), std::log(to))); }

Geodetic RandomViews::around(const Geodetic& at, double degrees) {
    return {std::clamp(at.latitude + degrees * share(-1, 1), -90.0, 90.0),
            std::remainder(at.longitude + degrees * share(-1, 1), 360.0)};
}

Geodetic RandomViews::next_place() {
    if (place_ && count_ % 2 == 0) return around(*place_, 1);
    if (share(0, 1) < 0.6) return {std::asin(share(-1, 1)) * 180 / std::numbers::pi, share(-180, 180)};
    constexpr double kCorner = 35.26438968275465;
    constexpr std::array<Geodetic, 10> kSpecial{{{90, 0},
                                                 {-90, 0},
                                                 {kCorner, 45},
                                                 {-kCorner, 135},
                                                 {kCorner, -135},
                                                 {-kCorner, -45},
                                                 {0, 180},
                                                 {-40, -180},
                                                 {20, 45},
                                                 {0, 0}}};
    const auto k = std::uniform_int_distribution<std::size_t>(0, kSpecial.size() - 1)(random_);
    return around(kSpecial[k], factor(1e-6, 1));
}

ViewRequest RandomViews::next() {
    const Geodetic place = next_place();
    return from(place, static_cast<Manner>(count_++ / 2 % 4));
}

ViewRequest RandomViews::from(const Geodetic& place, Manner manner) {
    ViewRequest view;
    view.width = width_;
    view.image_height = height_;
    view.eye = place;
    view.heading = share(0, 360);
    view.fov = share(20, 80);
    const double ground = surface_.sample(lattice_position(direction(view.eye))).height;
    const double scale = body_.a() / 6.4e6;
    switch (manner) {
        case Manner::globe:  // the globe or a part of it
            view.height = ground + scale * factor(1e5, 1e8);
            view.pitch = -90 + share(0, 0.9) * std::asin(body_.b() / (body_.a() + view.height)) * 180 /
                                   std::numbers::pi;
            break;
        case Manner::oblique:
            view.height = ground + scale * factor(1e3, 1e5);
            view.pitch = share(-80, -10);
            break;
        case Manner::grazing:
            view.height = ground + factor(20, 2000);
            view.pitch = share(-12, 3);
            break;
        case Manner::ground:
            view.height = ground + factor(3, 20);
            view.pitch = share(-60, 5);
    }
    return view;
}

}  // namespace carat::bench
