#include "manifest.hpp"

#include <fstream>
#include <nlohmann/json.hpp>

#include "carat/globe/error.hpp"
#include "kinds.hpp"

namespace carat::synth {
namespace {

using Json = nlohmann::ordered_json;

Json describe(const Written& f, std::size_t layer) {
    Json j;
    j["name"] = f.name;
    j["layer"] = layer;
    j["purpose"] = f.purpose;
    j["truth"] = f.truth_text;
    j["readable"] = f.readable;
    j["width"] = f.width;
    j["height"] = f.height;
    j["type"] = f.type == SampleType::float32 ? "float32" : "int16";
    j["nodata"] = f.nodata ? Json(*f.nodata) : Json(nullptr);
    j["crs"] = f.crs;
    j["bounds_deg"] = {f.bounds.west, f.bounds.south, f.bounds.east, f.bounds.north};
    j["spacing_m"] = f.spacing_m;
    j["min_wavelength_m"] = f.min_wavelength_m;
    return j;
}

}  // namespace

void write_manifest(Kind kind, const Options& options, const std::vector<Written>& files,
                    const std::filesystem::path& directory) {
    const Ellipsoid body = body_of(kind);
    Json j;
    j["kind"] = info_of(kind).name;
    j["description"] = info_of(kind).description;
    j["seed"] = options.seed;
    j["body"] = {{"name", body.name()}, {"equatorial_m", body.a()}, {"polar_m", body.b()}};
    j["heights"] = "metres above the ellipsoid along the geodetic normal, at pixel centres";
    j["layer_order"] = "where files overlap, the lower layer number has priority";
    j["files"] = Json::array();
    for (std::size_t i = 0; i < files.size(); ++i) j["files"].push_back(describe(files[i], i));

    const std::filesystem::path path = directory / kManifestName;
    const std::filesystem::path part = directory / (std::string(kManifestName) + ".part");
    {
        std::ofstream out(part, std::ios::binary);
        out << j.dump(2) << '\n';
        if (!out.flush()) throw Error(ErrorCode::io, part.string() + ": cannot write");
    }
    std::filesystem::rename(part, path);
}

}  // namespace carat::synth
