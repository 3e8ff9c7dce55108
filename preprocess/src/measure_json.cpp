// The summary of errors as JSON, in a file's provenance.
#include <cmath>
#include <nlohmann/json.hpp>

#include "carat/globe/error.hpp"
#include "carat/preprocess/measure.hpp"

namespace carat {
namespace {

using Json = nlohmann::ordered_json;

// To a micrometre, which keeps the text short; bounds are rounded up.
double rounded(double metres) { return std::round(metres * 1e6) / 1e6; }
double rounded_up(double metres) { return std::ceil(metres * 1e6) / 1e6; }
double rounded_degrees(double degrees) { return std::round(degrees * 1e8) / 1e8; }

Json json_of(const ErrorStats& s) {
    Json out{{"samples", s.count}};
    if (s.count == 0) return out;
    out.update({{"max_m", rounded_up(s.max)},
                {"rms_m", rounded(s.rms)},
                {"mean_m", rounded(s.mean)},
                {"p50_m", rounded_up(s.p50)},
                {"p90_m", rounded_up(s.p90)},
                {"p99_m", rounded_up(s.p99)},
                {"p99_9_m", rounded_up(s.p999)}});
    return out;
}

Json json_of(const WorstPlace& w) {
    return {{"lat", rounded_degrees(w.latitude)},
            {"lon", rounded_degrees(w.longitude)},
            {"source_m", rounded(w.source)},
            {"surface_m", rounded(w.surface)}};
}

Json json_of(const LayerErrors& l) {
    Json worst = Json::array();
    for (const WorstPlace& w : l.worst) worst.push_back(json_of(w));
    return {{"name", l.name},
            {"compared", json_of(l.compared)},
            {"blended", json_of(l.blended)},
            {"hidden", l.hidden},
            {"worst", worst}};
}

ErrorStats stats_of(const Json& j) {
    ErrorStats s;
    s.count = j.at("samples").get<std::uint64_t>();
    if (s.count == 0) return s;
    s.max = j.at("max_m").get<double>();
    s.rms = j.at("rms_m").get<double>();
    s.mean = j.at("mean_m").get<double>();
    s.p50 = j.at("p50_m").get<double>();
    s.p90 = j.at("p90_m").get<double>();
    s.p99 = j.at("p99_m").get<double>();
    s.p999 = j.at("p99_9_m").get<double>();
    return s;
}

LayerErrors layer_of(const Json& j) {
    LayerErrors l;
    l.name = j.at("name").get<std::string>();
    l.compared = stats_of(j.at("compared"));
    l.blended = stats_of(j.at("blended"));
    l.hidden = j.at("hidden").get<std::uint64_t>();
    for (const Json& w : j.at("worst"))
        l.worst.push_back({w.at("lat").get<double>(), w.at("lon").get<double>(),
                           w.at("source_m").get<double>(), w.at("surface_m").get<double>()});
    return l;
}

}  // namespace

std::string to_json(const ErrorSummary& summary) {
    Json layers = Json::array();
    for (const LayerErrors& l : summary.layers) layers.push_back(json_of(l));
    return Json{{"all", json_of(summary.all)}, {"layers", layers}}.dump();
}

ErrorSummary error_summary_of_json(const std::string& json) {
    try {
        const Json j = Json::parse(json);
        ErrorSummary out;
        out.all = stats_of(j.at("all"));
        for (const Json& l : j.at("layers")) out.layers.push_back(layer_of(l));
        return out;
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorCode::corrupt, std::string("a summary of errors is malformed: ") + error.what());
    }
}

}  // namespace carat
