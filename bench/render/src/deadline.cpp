#include "carat/bench/deadline.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <mutex>

#include "carat/codec/surface.hpp"
#include "carat/globe/locate.hpp"
#include "thread_usage.hpp"

namespace carat::bench {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds_since(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

View view_at(const Ellipsoid& body, const Flight& flight, double time, const DeadlineOptions& o) {
    ViewRequest request = flight.at(time);
    request.width = o.width;
    request.image_height = o.height;
    return {body, request};
}

double frame_time(const Flight& flight, int k, int frames) {
    return flight.duration() * k / std::max(1, frames - 1);
}

std::vector<double> plain_waits(double budget_ms, int count) {
    std::mutex mutex;
    std::condition_variable never;
    std::vector<double> out;
    std::unique_lock lock(mutex);
    for (int k = 0; k < count; ++k) {
        const Clock::time_point start = Clock::now();
        const auto until = start + std::chrono::nanoseconds(static_cast<std::int64_t>(budget_ms * 1e6));
        never.wait_until(lock, until, [] { return false; });
        out.push_back(milliseconds_since(start) - budget_ms);
    }
    return out;
}

// From the coarsest cut to the last view of the flight.
double seconds_to_converge(const OpenFile& open, const Ellipsoid& body, const Flight& flight,
                           double budget_ms, const DeadlineOptions& o) {
    Refiner refiner(open(), o.refiner);
    const View view = view_at(body, flight, flight.duration(), o);
    RefineBudget budget;
    budget.milliseconds = budget_ms;
    const Clock::time_point start = Clock::now();
    constexpr double kGiveUpMs = 60'000;
    while (!refiner.frame(view, o.goal, budget).converged)
        if (milliseconds_since(start) > kGiveUpMs) break;
    return milliseconds_since(start) / 1000;
}

// Waking up late may be both ready and overslept.
double own_ms(const LateFrame& l) {
    const double stolen = l.other_sleeps == 0 ? l.gone_ms : 0;
    return l.overrun_ms - std::max(l.ready_ms, l.overslept_ms) - stolen;
}

LateFrame late_frame(int k, double wall_ms, double budget_ms, const ThreadUsage& used,
                     const RefineCounters& c) {
    LateFrame out;
    out.frame = k;
    out.overrun_ms = wall_ms - budget_ms;
    out.processor_ms = used.cpu_ms;
    out.ready_ms = used.ready_ms;
    out.overslept_ms = c.overslept_ms;
    // Waking up late from a wait counts as waiting here.
    out.gone_ms = std::max(0.0, wall_ms - used.cpu_ms - used.ready_ms - c.wait_ms);
    out.other_sleeps = std::max<std::int64_t>(0, used.slept - static_cast<std::int64_t>(c.waits));
    out.preempted = used.preempted;
    out.faults = used.faults;
    out.by_us = std::max(own_ms(out), c.late_ms) > kLateMs;
    return out;
}

DeadlineRow measure(const OpenFile& open, const FlightPath& named, double budget_ms,
                    const DeadlineOptions& o) {
    const auto repository = open();
    const Ellipsoid body = repository->header().ellipsoid();
    const Flight flight(body, named.keyframes);
    Refiner refiner(repository, o.refiner);
    RefineBudget budget;
    budget.milliseconds = budget_ms;
    DeadlineRow row;
    row.flight = named.name;
    row.budget_ms = budget_ms;
    row.frames = static_cast<std::size_t>(o.frames);
    std::vector<double> overrun, late, own, error;
    RefinedFrame frame;
    double over_ms = 0;
    for (int k = 0; k < o.frames; ++k) {
        const View view = view_at(body, flight, frame_time(flight, k, o.frames), o);
        const ThreadUsage before = ThreadUsage::now();
        const Clock::time_point start = Clock::now();
        refiner.frame(view, o.goal, budget, frame);
        const double wall_ms = milliseconds_since(start);
        const LateFrame l = late_frame(k, wall_ms, budget_ms, ThreadUsage::now() - before, frame.counters);
        overrun.push_back(l.overrun_ms);
        late.push_back(frame.counters.late_ms);
        own.push_back(own_ms(l));
        row.other_sleeps += l.other_sleeps;
        if (l.overrun_ms > kLateMs) row.late_frames.push_back(l);
        error.push_back(frame.counters.worst_error);
        over_ms = frame.counters.worst_error > o.goal.threshold ? over_ms + wall_ms : 0;
        row.longest_over_seconds = std::max(row.longest_over_seconds, over_ms / 1000);
        row.pages += frame.counters.read.pages;
        row.within_share += frame.counters.worst_error <= o.goal.threshold ? 1.0 / o.frames : 0;
        row.converged_share += frame.converged ? 1.0 / o.frames : 0;
        row.greatest_triangles = std::max(row.greatest_triangles, frame.counters.triangles);
        row.forced_coarse += frame.counters.forced_coarse;
        row.decoded += static_cast<double>(frame.counters.decoded + frame.counters.predicted) / o.frames;
        row.uploads += static_cast<double>(frame.counters.uploads) / o.frames;
    }
    row.overrun = spread_of(std::move(overrun));
    row.late = spread_of(std::move(late));
    row.own = spread_of(std::move(own));
    row.median_error = spread_of(std::move(error)).median;
    row.wait_overrun = spread_of(plain_waits(budget_ms, o.frames));
    row.jump_seconds = seconds_to_converge(open, body, flight, budget_ms, o);
    return row;
}

}  // namespace

FlightPath flight_over(const std::shared_ptr<const Repository>& repository, const std::string& path,
                       const std::optional<Geodetic>& place) {
    const Surface surface(repository, 1);
    return read_flight_path(path, {place, [&](const Geodetic& at) {
                                       return surface.sample(lattice_position(direction(at))).height;
                                   }});
}

std::vector<FlightPath> shipped_flights(const std::shared_ptr<const Repository>& repository,
                                        const std::optional<Geodetic>& place) {
    std::vector<FlightPath> out;
    for (const std::string& name : shipped_flight_paths())
        out.push_back(flight_over(repository, name, place));
    return out;
}

Spread spread_of(std::vector<double> v) {
    if (v.empty()) return {};
    std::sort(v.begin(), v.end());
    // The least value that so many do not exceed.
    const auto at = [&](double share) {
        const double rank = std::ceil(share * static_cast<double>(v.size()));
        return v[static_cast<std::size_t>(std::max(rank, 1.0)) - 1];
    };
    return {at(0.5), at(0.99), at(0.999), v.back()};
}

std::vector<DeadlineRow> measure_deadlines(const OpenFile& open, const std::vector<FlightPath>& flights,
                                           const DeadlineOptions& o) {
    std::vector<DeadlineRow> rows;
    for (const FlightPath& flight : flights)
        for (const double budget : o.budgets_ms) {
            if (o.progress && !o.progress(flight.name, rows.size(), flights.size() * o.budgets_ms.size()))
                return rows;
            rows.push_back(measure(open, flight, budget, o));
        }
    return rows;
}

ScalingRow measure_flight(const std::shared_ptr<const Repository>& repository, const FlightPath& named,
                          const DeadlineOptions& o) {
    const Ellipsoid body = repository->header().ellipsoid();
    const Flight flight(body, named.keyframes);
    Refiner refiner(repository, o.refiner);
    ScalingRow row;
    row.file_bytes = repository->file_bytes();
    row.diamonds = repository->header().refined_diamonds;
    std::vector<double> total, selection;
    const double share = 1.0 / o.frames;
    for (int k = 0; k < o.frames; ++k) {
        const RefineCounters c =
            refiner.frame(view_at(body, flight, frame_time(flight, k, o.frames), o), o.goal).counters;
        total.push_back(c.total_ms);
        selection.push_back(c.selection_ms);
        row.work_ms += (c.decode_ms + c.build_ms) * share;
        row.triangles += static_cast<double>(c.triangles) * share;
        row.bytes_read += static_cast<double>(c.read.bytes) * share;
        row.pages += static_cast<double>(c.read.pages) * share;
        row.decoded += static_cast<double>(c.decoded + c.predicted) * share;
    }
    row.frame_ms = spread_of(std::move(total)).median;
    row.selection_ms = spread_of(std::move(selection)).median;
    return row;
}

}  // namespace carat::bench
