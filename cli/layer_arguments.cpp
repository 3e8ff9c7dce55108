#include "layer_arguments.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "carat/globe/error.hpp"
#include "values.hpp"

namespace carat::cli {
namespace {

std::array<double, 2> valid_range(const std::string& text) {
    const std::vector<double> v = parse_numbers(text, 2);
    if (!(v[0] <= v[1])) throw CLI::ValidationError("\"" + text + "\" is an empty range");
    return {v[0], v[1]};
}

std::array<double, 4> bounds(const std::string& text) {
    const std::vector<double> v = parse_numbers(text, 4);
    return {v[0], v[1], v[2], v[3]};
}

// METRES at holes and edges, or METRES,METRES.
void set_feather(LayerOptions& layer, const std::string& text) {
    const std::vector<double> v = parse_numbers(text, text.find(',') == std::string::npos ? 1 : 2);
    for (const double value : v)
        if (!(value >= 0)) throw CLI::ValidationError("\"" + text + "\" is negative");
    layer.feather = v[0];
    layer.feather_edges = v.size() > 1 ? std::optional(v[1]) : std::nullopt;
}

int band(const std::string& text) {
    constexpr double kGreatest = 65536;
    const double value = parse_number(text);
    if (value != std::floor(value) || value < 1 || value > kGreatest)
        throw CLI::ValidationError("\"" + text + "\" is not a band; the first is 1");
    return static_cast<int>(value);
}

LatitudeKind latitude(const std::string& text) {
    if (text == "automatic") return LatitudeKind::automatic;
    if (text == "geodetic") return LatitudeKind::geodetic;
    if (text == "geocentric") return LatitudeKind::geocentric;
    throw CLI::ValidationError("\"" + text + "\" is none of geodetic, geocentric, automatic");
}

// A raw value that is a hole; files may use NaN, which is always one.
double nodata(const std::string& text) {
    return text == "nan" || text == "NaN" ? std::nan("") : parse_number(text);
}

using Apply = void (*)(LayerOptions&, const std::string&);

const std::map<std::string, Apply>& appliers() {
    static const std::map<std::string, Apply> kAppliers{
        {"--geoid", [](LayerOptions& l, const std::string& v) { l.geoid = v; }},
        {"--valid-range", [](LayerOptions& l, const std::string& v) { l.valid_range = valid_range(v); }},
        {"--nodata", [](LayerOptions& l, const std::string& v) { l.nodata = nodata(v); }},
        {"--bounds", [](LayerOptions& l, const std::string& v) { l.bounds = bounds(v); }},
        {"--feather", set_feather},
        {"--resampling", [](LayerOptions& l, const std::string& v) { l.resampling = parse_resampling(v); }},
        {"--band", [](LayerOptions& l, const std::string& v) { l.band = band(v); }},
        {"--latitude", [](LayerOptions& l, const std::string& v) { l.latitude = latitude(v); }},
    };
    return kAppliers;
}

void apply(LayerOptions& layer, const std::string& name, const std::string& value) {
    try {
        appliers().at(name)(layer, value);
    } catch (const CLI::ValidationError& error) {
        throw Error(ErrorCode::usage, name + " of layer " + layer.files.front() + ": " + error.what());
    } catch (const Error& error) {
        throw Error(error.code(), name + " of layer " + layer.files.front() + ": " + error.what());
    }
}

}  // namespace

CLI::Option* LayerArguments::add(CLI::App& app, const std::string& name, const std::string& form,
                                 const std::string& description, const char* group) {
    app_ = &app;
    CLI::Option* option = app.add_option(name, description)
                              ->type_name(form)
                              ->type_size(1)
                              ->expected(1)
                              ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll)
                              ->group(group);
    options_.emplace_back(name, option);
    return option;
}

CLI::Option* LayerArguments::add_lead(CLI::App& app, const std::string& description, const char* group) {
    return add(app, lead_, "FILE[,FILE...]", description, group);
}

void LayerArguments::add_options(CLI::App& app, const char* group) {
    add(app, "--geoid", "GRID", "Heights are above this geoid (GeographicLib .pgm or a raster): add it",
        group);
    add(app, "--valid-range", "A,B", "Heights outside are holes, metres", group);
    add(app, "--nodata", "V", "This raw value is a hole", group);
    add(app, "--bounds", "W,S,E,N", "Degrees, outer edges; for files without a georeference", group);
    add(app, "--feather", "METRES[,METRES]",
        "Width over which the layer fades into those below, at holes and at outer edges (default: 4 samples "
        "and a sixteenth of the raster, 16 to 64 samples; one number: both; 0: a step)",
        group);
    add(app, "--resampling", "KIND", "nearest, bilinear (default) or cubic", group);
    add(app, "--band", "N", "Band of the rasters (default 1)", group);
    add(app, "--latitude", "KIND", "Of a body's raster: geodetic, geocentric or automatic (default)", group);
}

std::vector<LayerOptions> LayerArguments::layers(const Begin& begin) const {
    std::vector<LayerOptions> out;
    std::map<const CLI::Option*, std::size_t> next;  // occurrences met so far
    std::set<std::string> given;                     // for the present layer
    for (const CLI::Option* option : app_->parse_order()) {
        const auto it =
            std::find_if(options_.begin(), options_.end(), [&](const auto& o) { return o.second == option; });
        if (it == options_.end()) continue;
        const std::string& name = it->first;
        const std::string value = option->results().at(next[option]++);
        if (name == lead_) {
            try {
                out.push_back(begin(parse_files(value)));
            } catch (const CLI::ValidationError& error) {
                throw Error(ErrorCode::usage, lead_ + ": " + error.what());
            }
            given.clear();
            continue;
        }
        if (out.empty())
            throw Error(ErrorCode::usage,
                        name + " stands ahead of the first " + lead_ + ": it belongs after one");
        if (!given.insert(name).second)
            throw Error(ErrorCode::usage, name + " is given twice for layer " + out.back().files.front());
        apply(out.back(), name, value);
    }
    return out;
}

}  // namespace carat::cli
