// Whether frames keep their deadlines, and how soon the picture is right again after a jump. No GPU.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "carat/codec/repository.hpp"
#include "carat/render/flight_path.hpp"
#include "carat/render/refiner.hpp"

namespace carat::bench {

// The paths that Carat ships (flight_path.hpp), over the file's ground; at their own place or another.
std::vector<FlightPath> shipped_flights(const std::shared_ptr<const Repository>& repository,
                                        const std::optional<Geodetic>& place = {});
// One of them, or a file.
FlightPath flight_over(const std::shared_ptr<const Repository>& repository, const std::string& path,
                       const std::optional<Geodetic>& place = {});

// Of a series of frames, milliseconds.
struct Spread {
    double median = 0, p99 = 0, p999 = 0, worst = 0;
};
Spread spread_of(std::vector<double> values);

// A frame that came more than kLateMs after its budget, milliseconds. `by_us`: on a core of its own it would
// have, too.
constexpr double kLateMs = 1;
struct LateFrame {
    int frame = 0;  // of the flight, from 0
    double overrun_ms = 0;
    double processor_ms = 0;  // of the frame's thread
    double ready_ms = 0;      // it was ready, other threads had the processors
    double overslept_ms = 0;  // a wait that ends when it is asked to ended so much later
    // Neither on a processor nor ready nor waiting for results. With other_sleeps it was held up by a lock or
    // by memory; without, another guest of the host had the processor.
    double gone_ms = 0;
    std::int64_t other_sleeps = 0;  // than for results
    std::int64_t preempted = 0, faults = 0;
    bool by_us = false;
};

struct DeadlineRow {
    std::string flight;
    double budget_ms = 0;
    std::size_t frames = 0;
    Spread overrun;                 // of frame() beyond the budget, wall clock; below 0: done early
    Spread late;                    // the same by the frame thread's processor time (RefineCounters::late_ms)
    Spread own;                     // of overrun without what the machine took: ready, overslept or stolen
    std::int64_t other_sleeps = 0;  // of all frames
    std::vector<LateFrame> late_frames;
    Spread wait_overrun;  // of as many plain timed waits of that length in the same run: the machine's own
    double within_share = 0;     // of the frames: no drawn patch above the threshold
    double converged_share = 0;  // of the frames: and nothing finer than needed
    double median_error = 0;     // pixels: worst error bound among the drawn patches
    std::uint64_t greatest_triangles = 0, forced_coarse = 0;
    double decoded = 0, uploads = 0;  // a frame
    std::uint64_t pages = 0;          // read by all frames: the first finds none in memory
    // Wall clock: the longest run of frames with a patch above the threshold.
    double longest_over_seconds = 0;
    // To convergence at the flight's end from the coarsest cut, no page in memory.
    double jump_seconds = 0;
};

struct DeadlineOptions {
    std::vector<double> budgets_ms{4, 8, 16};
    RefineGoal goal;
    RefinerOptions refiner;
    int width = 1280, height = 720, frames = 1000;
    std::function<bool(const std::string&, std::size_t, std::size_t)> progress;  // false: stop
};

// Opens the file anew, with an empty cache: once for each row, and once for each jump.
using OpenFile = std::function<std::shared_ptr<const Repository>()>;
std::vector<DeadlineRow> measure_deadlines(const OpenFile& open, const std::vector<FlightPath>& flights,
                                           const DeadlineOptions& options);

// The cost of a converged flight, a frame.
struct ScalingRow {
    std::uint64_t file_bytes = 0, diamonds = 0;
    double frame_ms = 0;      // median, wall clock
    double selection_ms = 0;  // median: judging and changing the cut
    double work_ms = 0;       // mean, of the workers' decoding and building
    double triangles = 0, bytes_read = 0, pages = 0, decoded = 0;  // means
};
ScalingRow measure_flight(const std::shared_ptr<const Repository>& repository, const FlightPath& flight,
                          const DeadlineOptions& options);

}  // namespace carat::bench
