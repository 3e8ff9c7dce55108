// Progress reports, thinned and serialised.
#pragma once

#include <atomic>
#include <chrono>
#include <mutex>

#include "carat/preprocess/build.hpp"

namespace carat {

// Thread-safe. Throws Error(usage) "cancelled" from step() once the callback returned false.
class ProgressReporter {
  public:
    explicit ProgressReporter(const ProgressFunction& callback) : callback_(callback) {}

    void begin(BuildStage stage, std::uint64_t total);
    void step(std::uint64_t count = 1);
    // Reports at once. Throws as step() does.
    void flush();
    bool cancelled() const { return cancelled_; }
    // Seconds spent in each stage so far.
    std::vector<std::pair<BuildStage, double>> stage_seconds() const;

  private:
    using Clock = std::chrono::steady_clock;
    void report();

    const ProgressFunction& callback_;
    std::mutex mutex_;
    BuildStage stage_ = BuildStage::opening;
    std::uint64_t total_ = 0;
    std::atomic<std::uint64_t> done_{0};
    std::atomic<bool> cancelled_{false};
    Clock::time_point started_ = Clock::now(), last_report_{};
    std::vector<std::pair<BuildStage, double>> finished_;
};

}  // namespace carat
