#include "progress.hpp"

#include <fmt/core.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "interrupt.hpp"
#include "text.hpp"

namespace carat::cli {
namespace {

constexpr std::size_t kBarCells = 24;

std::size_t columns() {
    winsize size{};
    constexpr std::size_t kUsual = 80;
    return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0 ? size.ws_col : kUsual;
}

std::string bar(double share) {
    const auto full = static_cast<std::size_t>(share * static_cast<double>(kBarCells));
    return fmt::format("[{:#<{}}{:.<{}}] ", "", full, "", kBarCells - full);
}

}  // namespace

Progress::Progress(std::string unit, bool quiet, bool json)
    : unit_(std::move(unit)),
      quiet_(quiet && !json),
      json_(json),
      terminal_(!json && isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() { finish(); }

bool Progress::update(const std::string& stage, std::uint64_t done, std::uint64_t total) {
    if (interrupted()) return false;
    if (quiet_) return true;
    if (stage != stage_) begin_stage(stage);
    done_ = done;
    total_ = total;
    const auto now = Clock::now();
    const std::chrono::milliseconds pause(terminal_ ? 100 : json_ ? 500 : 5000);
    if (now - shown_ < pause) return true;
    shown_ = now;
    const double seconds = std::chrono::duration<double>(now - begun_).count();
    const std::string text = json_ ? json_line(seconds) : line(seconds);
    if (terminal_)
        fmt::print(stderr, "\r\x1b[K{}", text.substr(0, columns() - 1));
    else
        fmt::print(stderr, "{}\n", text);
    std::fflush(stderr);
    line_open_ = terminal_;
    return true;
}

void Progress::finish() {
    if (line_open_) fmt::print(stderr, "\r\x1b[K");
    std::fflush(stderr);
    line_open_ = false;
}

void Progress::begin_stage(const std::string& stage) {
    stage_ = stage;
    begun_ = Clock::now();
    shown_ = terminal_ || json_ ? Clock::time_point{} : begun_;  // these show every stage
}

std::string Progress::line(double seconds) const {
    std::string text = fmt::format("{:<12} ", stage_);
    if (total_ == 0) return text + fmt::format("{} {}, {}", grouped(done_), unit_, duration(seconds));
    const double share = std::clamp(static_cast<double>(done_) / static_cast<double>(total_), 0.0, 1.0);
    if (terminal_) text += bar(share);
    text += fmt::format("{:3.0f} %  {} of {} {}", 100 * share, grouped(done_), grouped(total_), unit_);
    if (seconds <= 0 || done_ == 0) return text;
    const double rate = static_cast<double>(done_) / seconds;
    const auto left = static_cast<double>(total_ - std::min(done_, total_));
    return text +
           fmt::format(", {}/s, {} left", grouped(static_cast<std::uint64_t>(rate)), duration(left / rate));
}

std::string Progress::json_line(double seconds) const {
    nlohmann::ordered_json out{{"stage", stage_}, {"done", done_}, {"unit", unit_}, {"seconds", seconds}};
    if (total_ > 0) out["total"] = total_;
    if (seconds > 0 && done_ > 0) {
        const double rate = static_cast<double>(done_) / seconds;
        out["per_second"] = rate;
        if (total_ > 0)
            out["remaining_seconds"] = static_cast<double>(total_ - std::min(done_, total_)) / rate;
    }
    return out.dump();
}

}  // namespace carat::cli
