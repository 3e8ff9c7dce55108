#include "build_report.hpp"

#include <fmt/core.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "error_report.hpp"
#include "text.hpp"

namespace carat::cli {
namespace {

using Json = nlohmann::ordered_json;

// JSON knows no infinity.
Json finite(double x) { return std::isfinite(x) ? Json(x) : Json(nullptr); }

Json to_json(const GeoBounds& b) { return {b.west, b.south, b.east, b.north}; }

Json to_json(const FileInfo& f) {
    return {{"path", f.path},
            {"driver", f.driver},
            {"width", f.width},
            {"height", f.height},
            {"bytes", f.bytes},
            {"bounds_wsen", to_json(f.bounds)},
            {"spacing_m", finite(f.spacing)},
            {"transformation", f.transformation}};
}

Json to_json(const LayerInfo& l) {
    Json files = Json::array();
    for (const FileInfo& f : l.files) files.push_back(to_json(f));
    return {{"name", l.name},
            {"files", files},
            {"bounds_wsen", to_json(l.bounds)},
            {"spacing_m", finite(l.spacing)},
            {"samples", l.samples},
            {"valid_samples", l.valid_samples},
            {"geoid", l.geoid}};
}

Json to_json(const LayerShare& s) {
    return {{"refined", s.refined}, {"zero", s.zero}, {"residual_bytes", s.residual_bytes}};
}

Json to_json(const BuildEstimate& e) {
    return {{"sampled_diamonds", e.sampled}, {"file_bytes", e.file_bytes}, {"seconds", e.seconds}};
}

Json to_json(const BuildPlan& plan, const BuildOptions& o) {
    Json layers = Json::array();
    for (const LayerInfo& l : plan.layers) layers.push_back(to_json(l));
    Json json{{"output", o.output.string()},
              {"tolerance_m", o.tolerance},
              {"vertical_datum", o.vertical_datum},
              {"layers", layers},
              {"warnings", plan.warnings},
              {"refined_by_level", plan.refined_by_level},
              {"refined_diamonds", plan.refined},
              {"leaf_samples", plan.leaf_samples},
              {"source_samples", plan.source_samples},
              {"temporary_bytes", plan.temporary_bytes},
              {"temporary_folder", plan.temporary_folder.string()}};
    if (plan.estimate) json["estimate"] = to_json(*plan.estimate);
    for (const LayerShare& s : plan.shares) json["shares"].push_back(to_json(s));
    return json;
}

Json to_json(const Certification& c) {
    Json worst = Json::array();
    for (const WorstPlace& w : c.worst)
        worst.push_back(
            {{"lat", w.latitude}, {"lon", w.longitude}, {"source_m", w.source}, {"surface_m", w.surface}});
    return {{"bound_m", c.bound}, {"reached", c.reached()},    {"samples", c.samples},
            {"beyond", c.beyond}, {"added_diamonds", c.added}, {"rounds", c.rounds},
            {"worst", worst}};
}

Json to_json(const BuildReport& r, const BuildOptions& o) {
    Json json = to_json(r.plan, o);
    Json stages = Json::object();
    for (const auto& [stage, seconds] : r.stage_seconds) stages[to_string(stage)] = seconds;
    json["file_bytes"] = r.file_bytes;
    if (r.plan.source_samples > 0)
        json["bits_per_source_sample"] =
            8.0 * static_cast<double>(r.file_bytes) / static_cast<double>(r.plan.source_samples);
    json["coded_diamonds"] = r.coded_diamonds;
    json["zero_diamonds"] = r.zero_diamonds;
    json["temporary_peak_bytes"] = r.temporary_peak_bytes;
    json["peak_memory_bytes"] = r.peak_memory_bytes;
    json["source_tiles"] = r.source_tiles;
    json["sampling_tile_reads"] = r.sampling_tile_reads;
    json["measuring_tile_reads"] = r.measuring_tile_reads;
    json["resumed_files"] = r.resumed_files;
    json["already_complete"] = r.already_complete;
    json["tolerance_m"] = r.tolerance;
    if (o.rms) json["rms_tolerance_m"] = *o.rms;
    json["max_error_m"] = finite(r.max_error);
    json["rms_error_m"] = finite(r.rms_error);
    if (r.certification) json["certification"] = to_json(*r.certification);
    if (r.errors) json["source_errors"] = errors_json(*r.errors);
    json["seconds"] = r.seconds;
    json["stage_seconds"] = stages;
    return json;
}

std::string bounds_text(const GeoBounds& b) {
    return fmt::format("{:.4f} {:.4f} {:.4f} {:.4f}", b.west, b.south, b.east, b.north);
}

void print_layers(const BuildPlan& plan) {
    for (std::size_t k = 0; k < plan.layers.size(); ++k) {
        const LayerInfo& l = plan.layers[k];
        fmt::print(
            "layer {}  {}: {} file{}, samples {} apart, {:.2f} % of {} valid, west south east north {}\n",
            k + 1, l.name, l.files.size(), l.files.size() == 1 ? "" : "s", length_text(l.spacing),
            100 * l.valid_share(), grouped(l.samples), bounds_text(l.bounds));
        if (!l.geoid.empty()) fmt::print("         heights raised by the geoid {}\n", l.geoid);
        for (const FileInfo& f : l.files)
            if (!f.transformation.empty()) fmt::print("         {}: {}\n", f.path, f.transformation);
    }
}

void print_text(const BuildPlan& plan) {
    print_layers(plan);
    fmt::print("depth    {} levels, {} refined diamonds, {} heights for {} source samples\n",
               plan.refined_by_level.size(), grouped(plan.refined), grouped(plan.leaf_samples),
               grouped(plan.source_samples));
}

void print_estimate(const BuildPlan& plan, const BuildEstimate& e) {
    fmt::print(
        "expected about {} of file, {} of time; at most {} of temporary files in {} ({} diamonds tried)\n",
        bytes_text(e.file_bytes), duration(e.seconds), bytes_text(plan.temporary_bytes),
        plan.temporary_folder.string(), grouped(e.sampled));
}

double ratio(double a, double b) { return b > 0 ? a / b : 0; }

void print_certification(const Certification& c) {
    if (c.reached())
        fmt::print(
            "certified no source sample is further than {} m: {} samples, {} diamonds more, {} rounds\n",
            number(c.bound), grouped(c.samples), grouped(c.added), c.rounds);
    else
        fmt::print("certified NO: {} of {} source samples are further than {} m\n", grouped(c.beyond),
                   grouped(c.samples), number(c.bound));
    for (const WorstPlace& w : c.worst)
        fmt::print("         {:.7f} {:.7f}: source {:.3f}, surface {:.3f}, {:+.3f}\n", w.latitude,
                   w.longitude, w.source, w.surface, w.surface - w.source);
}

}  // namespace

void print_plan(const BuildPlan& plan, const BuildOptions& options, bool json) {
    if (json)
        fmt::print("{}\n", to_json(plan, options).dump(2));
    else {
        print_text(plan);
        if (plan.estimate) print_estimate(plan, *plan.estimate);
    }
}

void print_report(const BuildReport& r, const BuildOptions& options, bool json) {
    if (json) {
        fmt::print("{}\n", to_json(r, options).dump(2));
        return;
    }
    print_text(r.plan);
    if (r.already_complete)
        fmt::print("resumed  the file was complete already; nothing was left to do\n");
    else
        fmt::print("error    at the file's own samples: greatest {:.4g} m, RMS {:.4g} m (tolerance {} m)\n",
                   r.max_error, r.rms_error, number(r.tolerance));
    if (options.rms) fmt::print("promise  RMS at most {} m\n", number(*options.rms));
    if (r.certification) print_certification(*r.certification);
    if (r.errors) print_errors(*r.errors, 1);
    fmt::print("file     {}: {} bytes ({})", options.output.string(), grouped(r.file_bytes),
               bytes_text(r.file_bytes));
    if (r.plan.source_samples > 0)
        fmt::print(", {:.3f} bits a source sample",
                   8.0 * static_cast<double>(r.file_bytes) / static_cast<double>(r.plan.source_samples));
    fmt::print("\nmemory   at most {} resident, {} of temporary files\n", bytes_text(r.peak_memory_bytes),
               bytes_text(r.temporary_peak_bytes));
    fmt::print("sources  {} tiles of samples; {} reads while sampling, {} while measuring\n",
               grouped(r.source_tiles), grouped(r.sampling_tile_reads), grouped(r.measuring_tile_reads));
    fmt::print("time     {}:", duration(r.seconds));
    for (const auto& [stage, seconds] : r.stage_seconds)
        fmt::print(" {} {}", to_string(stage), duration(seconds));
    fmt::print("\n");
    if (r.plan.estimate && !r.already_complete) {
        const BuildEstimate& e = *r.plan.estimate;
        fmt::print(
            "expected {} of file, {} of time, at most {} of temporary files; came out {:.2f}, {:.2f} and "
            "{:.2f} times that\n",
            bytes_text(e.file_bytes), duration(e.seconds), bytes_text(r.plan.temporary_bytes),
            ratio(static_cast<double>(r.file_bytes), static_cast<double>(e.file_bytes)),
            ratio(r.seconds, e.seconds),
            ratio(static_cast<double>(r.temporary_peak_bytes), static_cast<double>(r.plan.temporary_bytes)));
    }
}

}  // namespace carat::cli
