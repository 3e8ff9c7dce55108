#include "summary_code.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace carat {
namespace {

constexpr std::array<std::uint32_t, 16> kSixteenths{65536, 62758, 60097, 57549, 55109, 52773, 50536, 48393,
                                                    46341, 44377, 42495, 40694, 38968, 37316, 35734, 34219};

std::int64_t span(const SummaryRange& r) { return std::int64_t{r.max} - r.min; }

std::int64_t low(std::uint8_t code, const SummaryRange& r) { return r.min + span(r) * code / 255; }
std::int64_t high(std::uint8_t code, const SummaryRange& r) { return r.min + (span(r) * code + 254) / 255; }

}  // namespace

void SummaryRange::include(const SummaryValues& s) {
    min = std::min(min, s.min);
    max = std::max(max, s.max);
    auto up = static_cast<float>(s.delta);
    if (static_cast<double>(up) < s.delta) up = std::nextafter(up, std::numeric_limits<float>::infinity());
    delta = std::max(delta, up);
}

double decode_delta(std::uint8_t code, float greatest) {
    return std::ldexp(static_cast<double>(greatest) * kSixteenths[code % 16], -16 - code / 16);
}

std::uint8_t encode_delta(double delta, float greatest) {
    int code = 255;
    while (code > 0 && decode_delta(static_cast<std::uint8_t>(code), greatest) < delta) --code;
    return static_cast<std::uint8_t>(code);
}

SummaryCode encode_summary(const SummaryValues& s, const SummaryRange& range) {
    SummaryCode code;
    if (span(range) > 0) {
        auto down = (std::int64_t{s.min} - range.min) * 255 / span(range);
        while (down < 255 && low(static_cast<std::uint8_t>(down + 1), range) <= s.min) ++down;
        while (low(static_cast<std::uint8_t>(down), range) > s.min) --down;
        auto up = (std::int64_t{s.max} - range.min) * 255 / span(range);
        while (up > 0 && high(static_cast<std::uint8_t>(up - 1), range) >= s.max) --up;
        while (high(static_cast<std::uint8_t>(up), range) < s.max) ++up;
        code.min = static_cast<std::uint8_t>(down);
        code.max = static_cast<std::uint8_t>(up);
    }
    code.delta = encode_delta(s.delta, range.delta);
    return code;
}

SummaryValues decode_summary(const SummaryCode& code, const SummaryRange& range) {
    return {static_cast<std::int32_t>(low(code.min, range)), static_cast<std::int32_t>(high(code.max, range)),
            decode_delta(code.delta, range.delta)};
}

}  // namespace carat
