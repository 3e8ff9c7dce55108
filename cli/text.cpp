#include "text.hpp"

#include <fmt/core.h>

#include <array>
#include <cmath>

namespace carat::cli {

std::string grouped(std::uint64_t n) {
    const std::string digits = std::to_string(n);
    std::string text;
    for (std::size_t k = 0; k < digits.size(); ++k) {
        if (k > 0 && (digits.size() - k) % 3 == 0) text += ',';
        text += digits[k];
    }
    return text;
}

std::string bytes_text(std::uint64_t bytes) {
    static constexpr std::array<const char*, 6> kUnits{"B", "kB", "MB", "GB", "TB", "PB"};
    auto value = static_cast<double>(bytes);
    std::size_t unit = 0;
    for (; value >= 999.5 && unit + 1 < kUnits.size(); ++unit) value /= 1000;
    return unit == 0 ? fmt::format("{} B", bytes) : fmt::format("{:.3g} {}", value, kUnits[unit]);
}

std::string duration(double seconds) {
    if (seconds < 9.95) return fmt::format("{:.1f} s", seconds);
    const auto s = static_cast<std::uint64_t>(std::lround(std::fmin(seconds, 1e12)));
    if (s < 60) return fmt::format("{} s", s);
    if (s < 3600) return fmt::format("{} min {:02} s", s / 60, s % 60);
    return fmt::format("{} h {:02} min", s / 3600, s / 60 % 60);
}

std::string length_text(double metres) {
    const double size = std::abs(metres);
    if (size >= 1000) return fmt::format("{:.4g} km", metres / 1000);
    if (size >= 1 || size == 0) return fmt::format("{:.4g} m", metres);
    if (size >= 0.01) return fmt::format("{:.4g} cm", metres * 100);
    return fmt::format("{:.4g} mm", metres * 1000);
}

std::string number(double x) { return fmt::format("{}", x); }

}  // namespace carat::cli
