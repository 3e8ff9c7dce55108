#include "flight_stats.hpp"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <functional>

#include "carat/globe/error.hpp"
#include "text.hpp"

namespace carat::cli {
namespace {

struct Column {
    const char* name;
    std::function<std::string(const FrameRow&)> text;
};

Column count(const char* name, std::uint64_t RefineCounters::*member) {
    return {name, [member](const FrameRow& r) { return fmt::format("{}", r.cut.*member); }};
}
Column milliseconds(const char* name, double RefineCounters::*member) {
    return {name, [member](const FrameRow& r) { return fmt::format("{:.3f}", r.cut.*member); }};
}
Column milliseconds(const char* name, double FrameCounters::*member) {
    return {name, [member](const FrameRow& r) { return fmt::format("{:.3f}", r.gpu.*member); }};
}
Column milliseconds(const char* name, double FrameRow::*member) {
    return {name, [member](const FrameRow& r) { return fmt::format("{:.3f}", r.*member); }};
}

std::vector<Column> place_columns() {
    return {{"frame", [](const FrameRow& r) { return fmt::format("{}", r.frame); }},
            {"time_s", [](const FrameRow& r) { return fmt::format("{:.4f}", r.time); }},
            {"lat", [](const FrameRow& r) { return fmt::format("{:.7f}", r.where.eye.latitude); }},
            {"lon", [](const FrameRow& r) { return fmt::format("{:.7f}", r.where.eye.longitude); }},
            {"height_m", [](const FrameRow& r) { return fmt::format("{:.3f}", r.where.height); }}};
}

std::vector<Column> cut_columns() {
    using C = RefineCounters;
    return {{"converged", [](const FrameRow& r) { return r.converged ? "1" : "0"; }},
            {"worst_error_px", [](const FrameRow& r) { return fmt::format("{:.4f}", r.cut.worst_error); }},
            count("patches", &C::patches),
            count("triangles", &C::triangles),
            count("refined", &C::refined),
            count("virtual", &C::virtual_refined),
            count("culled_frustum", &C::culled_frustum),
            count("culled_horizon", &C::culled_horizon),
            {"culled_back", [](const FrameRow& r) { return fmt::format("{}", r.gpu.patches_back); }},
            count("waiting", &C::waiting),
            count("forced_coarse", &C::forced_coarse),
            {"pages_read", [](const FrameRow& r) { return fmt::format("{}", r.cut.read.pages); }},
            {"bytes_read", [](const FrameRow& r) { return fmt::format("{}", r.cut.read.bytes); }},
            count("decoded", &C::decoded),
            count("predicted", &C::predicted),
            count("virtual_decoded", &C::virtual_decoded),
            count("built", &C::built),
            {"uploaded", [](const FrameRow& r) { return fmt::format("{}", r.gpu.patches_uploaded); }},
            {"bytes_uploaded", [](const FrameRow& r) { return fmt::format("{}", r.gpu.bytes_uploaded); }}};
}

std::vector<Column> time_columns() {
    using C = RefineCounters;
    return {milliseconds("refine_ms", &C::total_ms),
            milliseconds("selection_ms", &C::selection_ms),
            milliseconds("stitch_ms", &C::stitch_ms),
            milliseconds("wait_ms", &C::wait_ms),
            milliseconds("decode_ms", &C::decode_ms),
            milliseconds("build_ms", &C::build_ms),
            milliseconds("upload_ms", &FrameCounters::upload_ms),
            milliseconds("stall_ms", &FrameCounters::stall_ms),
            milliseconds("gpu_ms", &FrameCounters::gpu_ms),
            milliseconds("readback_ms", &FrameCounters::readback_ms),
            milliseconds("write_ms", &FrameRow::write_ms),
            milliseconds("frame_ms", &FrameRow::frame_ms)};
}

const std::vector<Column>& columns() {
    static const std::vector<Column> all = [] {
        std::vector<Column> out = place_columns();
        for (const auto& part : {cut_columns(), time_columns()})
            out.insert(out.end(), part.begin(), part.end());
        return out;
    }();
    return all;
}

double per_second(std::uint64_t count, double milliseconds) {
    return milliseconds > 0 ? 1000 * static_cast<double>(count) / milliseconds : 0;
}

}  // namespace

FlightStats::FlightStats(const std::string& csv, std::uint64_t file_bytes, double fps, double budget_ms,
                         double threshold)
    : name_(csv),
      file_bytes_(static_cast<double>(file_bytes)),
      interval_ms_(1000 / fps),
      budget_ms_(budget_ms),
      threshold_(threshold) {
    if (name_.empty()) return;
    out_.open(name_);
    for (std::size_t k = 0; k < columns().size(); ++k) out_ << (k == 0 ? "" : ",") << columns()[k].name;
    out_ << '\n';
    if (!out_) throw Error(ErrorCode::io, name_ + ": cannot create");
}

void FlightStats::add(const FrameRow& r) {
    frame_ms_.push_back(r.frame_ms);
    refine_ms_.push_back(r.cut.total_ms);
    gpu_ms_.push_back(r.gpu.gpu_ms);
    error_.push_back(r.cut.worst_error);
    total_ms_ += r.frame_ms;
    total_gpu_ms_ += r.gpu.gpu_ms;
    triangles_ += r.cut.triangles;
    pages_ += r.cut.read.pages;
    bytes_ += r.cut.read.bytes;
    decoded_ += r.cut.decoded;
    predicted_ += r.cut.predicted;
    virtual_ += r.cut.virtual_decoded;
    uploads_ += r.gpu.patches_uploaded;
    upload_bytes_ += r.gpu.bytes_uploaded;
    most_uploaded_ = std::max(most_uploaded_, r.gpu.bytes_uploaded);
    stalls_ += r.gpu.stall_ms > 0 ? 1 : 0;
    stall_ms_ += r.gpu.stall_ms;
    converged_ += r.converged ? 1 : 0;
    if (name_.empty()) return;
    for (std::size_t k = 0; k < columns().size(); ++k) out_ << (k == 0 ? "" : ",") << columns()[k].text(r);
    out_ << '\n';
    if (!out_) throw Error(ErrorCode::io, name_ + ": cannot write");
}

// The least value that so many do not exceed.
FlightStats::Spread FlightStats::spread(std::vector<double> v) {
    std::sort(v.begin(), v.end());
    const auto at = [&](double share_below) {
        const double rank = std::ceil(share_below * static_cast<double>(v.size()));
        return v[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
    };
    return {at(0.5), at(0.95), at(0.99), v.back()};
}

double FlightStats::share(const std::vector<double>& values, double limit) const {
    const auto above = std::count_if(values.begin(), values.end(), [&](double x) { return x > limit; });
    return static_cast<double>(above) / static_cast<double>(values.size());
}

std::string FlightStats::text() const {
    const Spread frame = spread(frame_ms_), refine = spread(refine_ms_), error = spread(error_);
    std::string out = fmt::format(
        "{} frames, {} of them converged; frame p50/p95/p99/max {:.1f}/{:.1f}/{:.1f}/{:.1f} ms, {:.1f} % "
        "over "
        "{:.1f} ms\n",
        frame_ms_.size(), converged_, frame.p50, frame.p95, frame.p99, frame.max,
        100 * share(frame_ms_, interval_ms_), interval_ms_);
    out += fmt::format("refinement p50/p95/p99/max {:.2f}/{:.2f}/{:.2f}/{:.2f} ms", refine.p50, refine.p95,
                       refine.p99, refine.max);
    if (std::isfinite(budget_ms_))
        out += fmt::format(", {:.1f} % over the budget of {} ms", 100 * share(refine_ms_, budget_ms_),
                           budget_ms_);
    out += fmt::format(
        "\nworst error p50/p99/max {:.2f}/{:.2f}/{:.2f} px, {:.1f} % of frames over {} px; {} triangles/s, "
        "{} on the "
        "device\n",
        error.p50, error.p99, error.max, 100 * share(error_, threshold_), threshold_,
        grouped(static_cast<std::uint64_t>(per_second(triangles_, total_ms_))),
        grouped(static_cast<std::uint64_t>(per_second(triangles_, total_gpu_ms_))));
    out += fmt::format(
        "{} pages, {} read ({:.2f} % of the file); {} diamonds decoded, {} predicted, {} virtual; {} patches "
        "({}) uploaded, {} a frame at most; {} frames stalled for it, {:.1f} ms in all",
        grouped(pages_), bytes_text(bytes_), 100 * static_cast<double>(bytes_) / file_bytes_,
        grouped(decoded_), grouped(predicted_), grouped(virtual_), grouped(uploads_),
        bytes_text(upload_bytes_), bytes_text(most_uploaded_), stalls_, stall_ms_);
    return out;
}

nlohmann::ordered_json FlightStats::json(const Spread& s) {
    // JSON knows no infinity: an eye within a patch's error.
    const auto finite = [](double x) {
        return std::isfinite(x) ? nlohmann::ordered_json(x) : nlohmann::ordered_json(nullptr);
    };
    return {{"p50", finite(s.p50)}, {"p95", finite(s.p95)}, {"p99", finite(s.p99)}, {"max", finite(s.max)}};
}

nlohmann::ordered_json FlightStats::json() const {
    nlohmann::ordered_json out = {{"frames", frame_ms_.size()},
                                  {"converged_frames", converged_},
                                  {"frame_ms", json(spread(frame_ms_))},
                                  {"interval_ms", interval_ms_},
                                  {"share_over_interval", share(frame_ms_, interval_ms_)},
                                  {"refine_ms", json(spread(refine_ms_))},
                                  {"gpu_ms", json(spread(gpu_ms_))},
                                  {"worst_error_px", json(spread(error_))},
                                  {"share_over_threshold", share(error_, threshold_)}};
    if (std::isfinite(budget_ms_)) {
        out["budget_ms"] = budget_ms_;
        out["share_over_budget"] = share(refine_ms_, budget_ms_);
    }
    out["triangles"] = triangles_;
    out["triangles_per_second"] = per_second(triangles_, total_ms_);
    out["triangles_per_gpu_second"] = per_second(triangles_, total_gpu_ms_);
    out["read"] = {
        {"pages", pages_}, {"bytes", bytes_}, {"share_of_file", static_cast<double>(bytes_) / file_bytes_}};
    out["diamonds"] = {{"decoded", decoded_}, {"predicted", predicted_}, {"virtual", virtual_}};
    out["uploads"] = {{"patches", uploads_},
                      {"bytes", upload_bytes_},
                      {"bytes_a_frame_max", most_uploaded_},
                      {"stalled_frames", stalls_},
                      {"stall_ms", stall_ms_}};
    return out;
}

}  // namespace carat::cli
