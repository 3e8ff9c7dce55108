// Summaries in a page: three bytes a half, relative to the page's own range, rounded outwards. Integers
// decide.
#pragma once

#include <array>
#include <cstdint>

#include "carat/codec/summary.hpp"

namespace carat {

// What a page says about the range of its summaries.
struct SummaryRange {
    std::int32_t min = 0, max = 0;  // quanta
    float delta = 0;                // metres, the greatest of the page, rounded up

    void include(const SummaryValues& s);
};

struct SummaryCode {
    std::uint8_t min = 0, max = 0, delta = 0;
};

SummaryCode encode_summary(const SummaryValues& s, const SummaryRange& range);
SummaryValues decode_summary(const SummaryCode& code, const SummaryRange& range);

// delta = range.delta * T[code % 16] / 2^16 / 2^(code / 16), T[k] = ceil(2^16 * 2^(-k/16)): at most 4.5 % too
// large.
double decode_delta(std::uint8_t code, float greatest);
std::uint8_t encode_delta(double delta, float greatest);

}  // namespace carat
