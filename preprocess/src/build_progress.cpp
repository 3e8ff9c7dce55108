#include "build_progress.hpp"

#include "carat/globe/error.hpp"

namespace carat {

const char* to_string(BuildStage stage) {
    switch (stage) {
        case BuildStage::opening:
            return "opening";
        case BuildStage::planning:
            return "planning";
        case BuildStage::certifying:
            return "certifying";
        case BuildStage::sampling:
            return "sampling";
        case BuildStage::coding:
            return "coding";
        case BuildStage::summarising:
            return "summarising";
        case BuildStage::writing:
            return "writing";
        case BuildStage::measuring:
            return "measuring";
    }
    return "unknown";
}

void ProgressReporter::begin(BuildStage stage, std::uint64_t total) {
    const std::lock_guard lock(mutex_);
    const auto now = Clock::now();
    finished_.emplace_back(stage_, std::chrono::duration<double>(now - started_).count());
    started_ = now;
    stage_ = stage;
    total_ = total;
    done_ = 0;
    report();
}

void ProgressReporter::step(std::uint64_t count) {
    done_.fetch_add(count, std::memory_order_relaxed);
    if (mutex_.try_lock()) {
        const std::lock_guard lock(mutex_, std::adopt_lock);
        if (Clock::now() - last_report_ > std::chrono::milliseconds(100)) report();
    }
    if (cancelled_) throw Error(ErrorCode::usage, "cancelled");
}

void ProgressReporter::flush() {
    {
        const std::lock_guard lock(mutex_);
        report();
    }
    if (cancelled_) throw Error(ErrorCode::usage, "cancelled");
}

void ProgressReporter::report() {
    last_report_ = Clock::now();
    if (callback_ && !callback_({stage_, done_, total_})) cancelled_ = true;
}

std::vector<std::pair<BuildStage, double>> ProgressReporter::stage_seconds() const {
    auto all = finished_;
    all.emplace_back(stage_, std::chrono::duration<double>(Clock::now() - started_).count());
    return all;
}

}  // namespace carat
