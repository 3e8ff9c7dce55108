#include "carat/render/flight.hpp"

#include <GeographicLib/Geodesic.hpp>
#include <algorithm>
#include <cmath>
#include <string>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

double mix(double a, double b, double u) { return a + u * (b - a); }

// Degrees in [-180, 180).
double shorter_turn(double from, double to) { return std::remainder(to - from, 360.0); }

// Fraction of the way at fraction u of the time when speed is proportional to height.
double way_flown(double height_ratio, double u) {
    const double k = std::log(height_ratio);
    return std::abs(k) < 1e-6 ? u : std::expm1(k * u) / std::expm1(k);
}

void check(const std::vector<Keyframe>& keys) {
    if (keys.size() < 2) throw Error(ErrorCode::usage, "a path needs at least two keyframes");
    for (std::size_t k = 0; k < keys.size(); ++k) {
        const std::string name = "keyframe " + std::to_string(k + 1);
        (void)direction(keys[k].eye);  // refuses what is no place
        if (!(keys[k].height > keys[k].base) || !std::isfinite(keys[k].height - keys[k].base))
            throw Error(ErrorCode::usage, name + (keys[k].base == 0 ? ": height must be positive"
                                                                    : ": height must be above the base"));
        if (k > 0 && !(keys[k].time > keys[k - 1].time))
            throw Error(ErrorCode::usage, name + ": times must ascend");
    }
}

}  // namespace

Flight::Flight(const Ellipsoid& body, std::vector<Keyframe> keyframes)
    : a_(body.a()), f_((body.a() - body.b()) / body.a()), keys_(std::move(keyframes)) {
    check(keys_);
    const GeographicLib::Geodesic earth(a_, f_);
    for (std::size_t k = 0; k + 1 < keys_.size(); ++k) {
        Segment s;
        double arrival = 0;
        earth.Inverse(keys_[k].eye.latitude, keys_[k].eye.longitude, keys_[k + 1].eye.latitude,
                      keys_[k + 1].eye.longitude, s.distance, s.azimuth, arrival);
        segments_.push_back(s);
    }
}

double Flight::duration() const { return keys_.back().time - keys_.front().time; }

// Uniform motion with quadratic ramps of length r at both ends; covers the same time in the same time.
double Flight::eased(double time) const {
    const double total = duration(), r = std::min(1.0, total / 10);
    const double t = std::clamp(time, 0.0, total);
    const double speed = total / (total - r);
    if (t < r) return speed * t * t / (2 * r);
    if (t > total - r) return total - speed * (total - t) * (total - t) / (2 * r);
    return speed * (t - r / 2);
}

ViewRequest Flight::at(double time) const {
    const double t = keys_.front().time + eased(time);
    std::size_t k = 0;
    while (k + 2 < keys_.size() && t >= keys_[k + 1].time) ++k;
    const Keyframe &from = keys_[k], &to = keys_[k + 1];
    const double u = std::clamp((t - from.time) / (to.time - from.time), 0.0, 1.0);

    ViewRequest view;
    const double ratio = (to.height - to.base) / (from.height - from.base);
    const double flown = way_flown(ratio, u) * segments_[k].distance;
    GeographicLib::Geodesic(a_, f_).Direct(from.eye.latitude, from.eye.longitude, segments_[k].azimuth, flown,
                                           view.eye.latitude, view.eye.longitude);
    view.height = mix(from.base, to.base, u) + (from.height - from.base) * std::pow(ratio, u);
    view.heading = from.heading + u * shorter_turn(from.heading, to.heading);
    view.pitch = mix(from.pitch, to.pitch, u);
    view.fov = mix(from.fov, to.fov, u);
    return view;
}

}  // namespace carat
