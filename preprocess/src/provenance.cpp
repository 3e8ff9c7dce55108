#include "carat/preprocess/provenance.hpp"

#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "carat/globe/error.hpp"
#include "content_hash.hpp"

namespace carat {
namespace {

using Json = nlohmann::ordered_json;

std::string name_of(const std::string& path) { return std::filesystem::path(path).filename().string(); }

// JSON knows no NaN.
Json number(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }
double number(const Json& j) { return j.is_null() ? std::nan("") : j.get<double>(); }

const char* to_string(LatitudeKind kind) {
    switch (kind) {
        case LatitudeKind::geodetic:
            return "geodetic";
        case LatitudeKind::geocentric:
            return "geocentric";
        case LatitudeKind::automatic:
            break;
    }
    return "automatic";
}

LatitudeKind parse_latitude(const std::string& text) {
    for (const LatitudeKind k : {LatitudeKind::geodetic, LatitudeKind::geocentric})
        if (text == to_string(k)) return k;
    return LatitudeKind::automatic;
}

Json file_json(const FileInfo& f) {
    return {{"name", name_of(f.path)},
            {"bytes", f.bytes},
            {"xxh3", f.hash},
            {"width", f.width},
            {"height", f.height}};
}

Json share_json(const LayerShare& s) {
    return {{"refined", s.refined}, {"zero", s.zero}, {"residual_bytes", s.residual_bytes}};
}

Json layer_json(const LayerInfo& info, const LayerOptions& options) {
    Json files = Json::array();
    for (const FileInfo& f : info.files) files.push_back(file_json(f));
    Json out{{"name", info.name}, {"files", files}, {"resampling", to_string(options.resampling)}};
    if (options.nodata) out["nodata"] = number(*options.nodata);
    if (options.valid_range) out["valid_range"] = *options.valid_range;
    if (options.bounds) out["bounds"] = *options.bounds;
    if (!options.geoid.empty()) {
        out["geoid"] = name_of(options.geoid);
        out["geoid_xxh3"] = content_hash({options.geoid}).hash;
    }
    if (options.feather) out["feather_m"] = *options.feather;
    if (options.feather_edges) out["feather_edges_m"] = *options.feather_edges;
    if (options.band != 1) out["band"] = options.band;
    if (options.colour_component) out["colour_component"] = *options.colour_component;
    if (options.latitude != LatitudeKind::automatic) out["latitude"] = to_string(options.latitude);
    return out;
}

RecordedLayer recorded_layer(const Json& j) {
    RecordedLayer out;
    LayerOptions& o = out.options;
    for (const Json& f : j.at("files")) {
        out.files.push_back({f.at("name").get<std::string>(), f.at("bytes").get<std::uint64_t>(),
                             f.at("xxh3").get<std::uint64_t>()});
        o.files.push_back(out.files.back().name);
    }
    o.resampling = parse_resampling(j.at("resampling").get<std::string>());
    if (j.contains("nodata")) o.nodata = number(j["nodata"]);
    if (j.contains("valid_range")) o.valid_range = j["valid_range"].get<std::array<double, 2>>();
    if (j.contains("bounds")) o.bounds = j["bounds"].get<std::array<double, 4>>();
    if (j.contains("geoid")) o.geoid = j["geoid"].get<std::string>();
    if (j.contains("geoid_xxh3")) out.geoid_hash = j["geoid_xxh3"].get<std::uint64_t>();
    if (j.contains("feather_m")) o.feather = j["feather_m"].get<double>();
    if (j.contains("feather_edges_m")) o.feather_edges = j["feather_edges_m"].get<double>();
    o.band = j.value("band", 1);
    if (j.contains("colour_component")) o.colour_component = j["colour_component"].get<int>();
    o.latitude = parse_latitude(j.value("latitude", "automatic"));
    return out;
}

}  // namespace

std::string provenance_json(const BuildOptions& o, const BuildPlan& plan, const ErrorSummary* errors,
                            const std::optional<Certification>& certification) {
    Json layers = Json::array();
    for (std::size_t k = 0; k < plan.layers.size(); ++k)
        layers.push_back(layer_json(plan.layers[k], o.layers[k]));
    Json out{{"program", "carat"},
             {"layers", layers},
             {"base_height", o.base_height},
             {"mode", static_cast<int>(o.mode)},
             {"depth_bias", o.depth_bias},
             {"max_level", o.max_level},
             {"source_samples", plan.source_samples}};
    if (!plan.shares.empty()) {
        Json shares = Json::array();
        for (const LayerShare& s : plan.shares) shares.push_back(share_json(s));
        out["shares"] = shares;
    }
    if (o.coding.orders != Coding{}.orders) out["orders"] = o.coding.orders;
    if (o.certify) out["certify_m"] = *o.certify;
    if (certification && certification->reached())
        out["certificate"] = {{"bound_m", certification->bound}, {"samples", certification->samples}};
    if (errors != nullptr) out["source_errors"] = Json::parse(to_json(*errors));
    return out.dump();
}

bool same_build(const std::string& recorded, const BuildOptions& options, const BuildPlan& plan,
                const std::optional<Certification>& certification) {
    Json there = Json::parse(recorded, nullptr, false);
    if (!there.is_object() || there.contains("source_errors") != options.measures()) return false;
    Json here = Json::parse(provenance_json(options, plan, nullptr, certification));
    for (Json* json : {&there, &here}) json->erase("shares");
    there.erase("source_errors");
    return there == here;
}

// All fields at their longest: 24 characters a number.
std::size_t measured_room(const std::string& provenance, const BuildPlan& plan) {
    constexpr std::size_t kStats = 300, kPlace = 150, kLayer = 2 * kStats + kRecordedPlaces * kPlace + 150;
    std::size_t room = provenance.size() + kStats + 100;
    for (const LayerInfo& layer : plan.layers) room += kLayer + Json(layer.name).dump().size();
    return room;
}

Provenance parse_provenance(const std::string& json) {
    try {
        const Json j = Json::parse(json);
        Provenance out;
        for (const Json& layer : j.at("layers")) out.layers.push_back(recorded_layer(layer));
        out.base_height = j.at("base_height").get<double>();
        out.mode = static_cast<Mode>(j.at("mode").get<int>());
        out.depth_bias = j.at("depth_bias").get<double>();
        out.max_level = j.at("max_level").get<int>();
        out.source_samples = j.value("source_samples", std::uint64_t{0});
        out.orders = j.value("orders", Coding{}.orders);
        if (j.contains("certify_m")) out.certify = j["certify_m"].get<double>();
        if (j.contains("shares"))
            for (const Json& s : j["shares"])
                out.shares.push_back({s.at("refined").get<std::uint64_t>(), s.at("zero").get<std::uint64_t>(),
                                      s.at("residual_bytes").get<std::uint64_t>()});
        if (j.contains("certificate")) out.certificate = j["certificate"].at("bound_m").get<double>();
        if (j.contains("source_errors")) out.errors = error_summary_of_json(j["source_errors"].dump());
        return out;
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorCode::corrupt, std::string("the file's provenance is malformed: ") + error.what());
    }
}

}  // namespace carat
