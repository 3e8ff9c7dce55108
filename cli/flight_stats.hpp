// What each frame of a flight cost, as CSV, and all of them in short.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "carat/render/refiner.hpp"
#include "carat/vulkan/renderer.hpp"

namespace carat::cli {

struct FrameRow {
    int frame = 0;    // from 1
    double time = 0;  // seconds of the flight
    ViewRequest where;
    bool converged = false;
    RefineCounters cut;
    FrameCounters gpu;
    double frame_ms = 0;  // wall time: refining, submitting and waiting for the frame before; not writing
    double write_ms = 0;  // of the picture
};

class FlightStats {
  public:
    // csv: a file, or "" for none. budget_ms: of refinement; infinity: frames are converged. threshold:
    // pixels. Throws Error(io).
    FlightStats(const std::string& csv, std::uint64_t file_bytes, double fps, double budget_ms,
                double threshold);

    // Frames in order. Throws Error(io).
    void add(const FrameRow& row);
    // A few lines. Precondition: a frame has been added.
    std::string text() const;
    nlohmann::ordered_json json() const;

  private:
    struct Spread {
        double p50 = 0, p95 = 0, p99 = 0, max = 0;
    };
    static Spread spread(std::vector<double> values);
    static nlohmann::ordered_json json(const Spread& s);
    double share(const std::vector<double>& values, double limit) const;  // of frames above it

    std::string name_;
    std::ofstream out_;
    double file_bytes_, interval_ms_, budget_ms_, threshold_;
    std::vector<double> frame_ms_, refine_ms_, gpu_ms_, error_;
    std::uint64_t triangles_ = 0, pages_ = 0, bytes_ = 0, decoded_ = 0, predicted_ = 0, virtual_ = 0,
                  uploads_ = 0, upload_bytes_ = 0, most_uploaded_ = 0, stalls_ = 0, converged_ = 0;
    double total_ms_ = 0, total_gpu_ms_ = 0, stall_ms_ = 0;
};

}  // namespace carat::cli
