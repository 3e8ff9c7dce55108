// Progress of long work on stderr: a bar with rate and remaining time on a terminal, a plain line every few
// seconds otherwise, nothing with -q; or, for programs, a JSON object on a line of its own twice a second.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

namespace carat::cli {

class Progress {
  public:
    // unit: what is counted, in the plural ("diamonds").
    Progress(std::string unit, bool quiet, bool json = false);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    // What is counted from now on.
    void count(const std::string& unit) { unit_ = unit; }
    // Call as often as you like. A new stage starts its own clock. total 0: unknown. Not thread-safe.
    // Returns false once the user has interrupted, so that it may end a library's progress function.
    bool update(const std::string& stage, std::uint64_t done, std::uint64_t total);
    // Ends the line of a bar, so that other text may follow.
    void finish();

  private:
    using Clock = std::chrono::steady_clock;

    void begin_stage(const std::string& stage);
    std::string line(double seconds) const;
    std::string json_line(double seconds) const;

    std::string unit_;
    bool quiet_, json_, terminal_;
    std::string stage_;
    std::uint64_t done_ = 0, total_ = 0;
    Clock::time_point begun_, shown_;
    bool line_open_ = false;
};

}  // namespace carat::cli
