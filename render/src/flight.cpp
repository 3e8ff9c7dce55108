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
    heading_ = turn(&Keyframe::heading, true);
    pitch_ = turn(&Keyframe::pitch, false);
    fov_ = turn(&Keyframe::fov, false);
    roll_ = turn(&Keyframe::roll, true);
}

double Flight::duration() const { return keys_.back().time - keys_.front().time; }

// The weighted harmonic mean of the rates on both sides, 0 where these differ in sign: monotone between
// keyframes (Fritsch and Butland, SIAM J. Sci. Stat. Comput. 5, 1984). At the ends that of the segment.
Flight::Turn Flight::turn(double Keyframe::*angle, bool by_shorter_way) const {
    Turn out{{keys_[0].*angle}, {}};
    std::vector<double> seconds, rate;
    for (std::size_t k = 0; k + 1 < keys_.size(); ++k) {
        const double from = keys_[k].*angle, to = keys_[k + 1].*angle;
        const double step = by_shorter_way ? shorter_turn(from, to) : to - from;
        out.value.push_back(out.value.back() + step);
        seconds.push_back(keys_[k + 1].time - keys_[k].time);
        rate.push_back(step / seconds.back());
    }
    out.rate.push_back(rate.front());
    for (std::size_t k = 1; k < rate.size(); ++k) {
        const double w = 2 * seconds[k] + seconds[k - 1], v = seconds[k] + 2 * seconds[k - 1];
        out.rate.push_back(rate[k - 1] * rate[k] > 0 ? (w + v) / (w / rate[k - 1] + v / rate[k]) : 0);
    }
    out.rate.push_back(rate.back());
    return out;
}

// Hermite's cubic.
double Flight::at(const Turn& turn, std::size_t k, double u) const {
    const double seconds = keys_[k + 1].time - keys_[k].time, v = 1 - u;
    return v * v * ((1 + 2 * u) * turn.value[k] + u * seconds * turn.rate[k]) +
           u * u * ((1 + 2 * v) * turn.value[k + 1] - v * seconds * turn.rate[k + 1]);
}

// Over the first w seconds the time flown is w (2 s^2 - s^3), s = time / w: from rest to the common speed,
// and all w of them. Likewise at the end.
double Flight::eased(double time) const {
    const double total = duration(), most = std::min(4.0, 0.4 * total);
    const auto window = [&](std::size_t k) { return std::min(most, keys_[k + 1].time - keys_[k].time); };
    const auto flown = [](double t, double w) { return t < w ? t * t / w * (2 - t / w) : t; };
    const double t = std::clamp(time, 0.0, total);
    return t < total / 2 ? flown(t, window(0)) : total - flown(total - t, window(segments_.size() - 1));
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
    view.heading = at(heading_, k, u);
    view.pitch = std::clamp(at(pitch_, k, u), -90.0, 90.0);  // between keyframes, but for roundings
    view.fov = at(fov_, k, u);
    view.roll = at(roll_, k, u);
    return view;
}

}  // namespace carat
