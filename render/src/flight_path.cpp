#include "carat/render/flight_path.hpp"

#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

using Json = nlohmann::json;

struct ShippedPath {
    const char* name;
    const char* text;
};
const ShippedPath kShipped[] = {
#include "shipped_flights.inc"
};

// The path's place, and the ground there once it is asked for.
class Site {
  public:
    Site(const Json& path, const FlightSite& site) : ground_at_(site.ground) {
        if (path.is_object() && path.contains("place")) {
            const auto own = path.at("place").get<std::vector<double>>();
            if (own.size() != 2) throw Error(ErrorCode::corrupt, "\"place\" is [LAT, LON]");
            place_ = site.place.value_or(Geodetic{own[0], own[1]});
        } else if (site.place) {
            throw Error(ErrorCode::usage, "the path is not round a place and cannot be flown at another");
        }
    }
    const Geodetic& place() const {
        if (!place_)
            throw Error(ErrorCode::corrupt, "\"north\", \"east\", \"above\" and \"over\" need a \"place\"");
        return *place_;
    }
    double ground() {
        if (!ground_) ground_ = ground_at_ ? ground_at_(place()) : 0;
        return *ground_;
    }

  private:
    std::function<double(const Geodetic&)> ground_at_;
    std::optional<Geodetic> place_;
    std::optional<double> ground_;
};

Keyframe keyframe(const Json& j, Site& site) {
    Keyframe k;
    k.time = j.at("time").get<double>();
    if (j.contains("north") || j.contains("east")) {
        const Geodetic& place = site.place();
        k.eye.latitude = place.latitude + j.value("north", 0.0);
        k.eye.longitude = std::remainder(place.longitude + j.value("east", 0.0), 360.0);
    } else {
        k.eye = {j.at("lat").get<double>(), j.at("lon").get<double>()};
    }
    if (j.contains("over")) {
        (void)site.place();
        k.base = site.ground();
        k.height = k.base + j.at("over").get<double>();
    } else if (j.contains("above")) {
        (void)site.place();
        k.height = site.ground() + j.at("above").get<double>();
    } else {
        k.height = j.at("height").get<double>();
    }
    k.heading = j.value("heading", k.heading);
    k.pitch = j.value("pitch", k.pitch);
    k.fov = j.value("fov", k.fov);
    k.roll = j.value("roll", k.roll);
    return k;
}

}  // namespace

FlightPath parse_flight_path(const std::string& json, const std::string& source, const FlightSite& site) {
    try {
        const Json path = Json::parse(json);
        Site where(path, site);
        FlightPath out;
        out.name = path.is_object() ? path.value("name", source) : source;
        for (const Json& j : path.is_object() ? path.at("keyframes") : path)
            out.keyframes.push_back(keyframe(j, where));
        return out;
    } catch (const Json::exception& e) {
        throw Error(ErrorCode::corrupt, source + ": " + e.what());
    } catch (const Error& e) {
        throw Error(e.code(), source + ": " + e.what());
    }
}

FlightPath read_flight_path(const std::string& path, const FlightSite& site) {
    std::ifstream in(path, std::ios::binary);
    if (in) return parse_flight_path({std::istreambuf_iterator<char>(in), {}}, path, site);
    for (const ShippedPath& shipped : kShipped)
        if (path == shipped.name) return parse_flight_path(shipped.text, path, site);
    throw Error(ErrorCode::io, path + ": no such file, nor a path of that name");
}

std::vector<std::string> shipped_flight_paths() {
    std::vector<std::string> names;
    for (const ShippedPath& shipped : kShipped) names.emplace_back(shipped.name);
    return names;
}

}  // namespace carat
