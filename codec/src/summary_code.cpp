#include "summary_code.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace carat {
namespace {

constexpr std::array<std::uint32_t, 16> kSixteenths{65536,  68438,  71468,  74632, 77936,  81387,
                                                    84990,  88753,  92682,  96786, 101071, 105546,
                                                    110218, 115098, 120194, 125515};
constexpr int kLeastExponent = -40;

// To a multiple of unit, a power of two, towards minus infinity.
std::int64_t floor_to(std::int64_t x, std::int64_t unit) { return x & ~(unit - 1); }

struct SummaryCode {
    std::uint64_t min = 0, span = 0, delta = 0;

    SummaryCode(const SummaryValues& s, const SummaryRange& range, std::int64_t unit)
        : min(static_cast<std::uint64_t>((std::int64_t{s.min} - floor_to(range.min, unit)) / unit)),
          span(static_cast<std::uint64_t>((std::int64_t{s.max} - s.min + unit - 1) / unit)),
          delta(static_cast<std::uint64_t>(range.delta - index_of_delta(s.delta))) {}
};

}  // namespace

double delta_of_index(int index) {
    return std::ldexp(static_cast<double>(kSixteenths[static_cast<std::size_t>(index % 16)]),
                      index / 16 + kLeastExponent - 16);
}

int index_of_delta(double delta) {
    int low = 0, high = kGreatestDeltaIndex;
    while (low < high) {
        const int middle = (low + high) / 2;
        if (delta_of_index(middle) >= delta)
            high = middle;
        else
            low = middle + 1;
    }
    return low;
}

void SummaryRange::include(const SummaryValues& s) {
    min = std::min(min, s.min);
    max = std::max(max, s.max);
    delta = std::max(delta, index_of_delta(s.delta));
}

SummaryGrid::SummaryGrid(double a, double quantum, int log2_cells)
    : exponent_(std::clamp(std::ilogb(a / quantum), -100, 100)), log2_cells_(log2_cells) {}

// About a sixteenth of the spacing of a level's vertices, at most a / 2^19.
std::int64_t SummaryGrid::unit(int level) const {
    const int k = std::min(exponent_ - 19, exponent_ - log2_cells_ - 3 - level / 2);
    return std::int64_t{1} << std::clamp(k, 0, kGreatestUnit);
}

SummaryValues SummaryGrid::rounded(const SummaryValues& s, int level) const {
    const std::int64_t u = unit(level), up = floor_to(std::int64_t{s.max} + u - 1, u);
    return {static_cast<std::int32_t>(floor_to(s.min, u)),
            static_cast<std::int32_t>(std::min(up, std::int64_t{INT32_MAX})),
            delta_of_index(index_of_delta(s.delta))};
}

std::size_t summary_bytes(const SummaryValues& s, const SummaryRange& range, std::int64_t unit) {
    const SummaryCode c(s, range, unit);
    return varint_bytes(c.min) + varint_bytes(c.span) + varint_bytes(c.delta);
}

void put_summary(std::vector<std::byte>& out, const SummaryValues& s, const SummaryRange& range,
                 std::int64_t unit) {
    const SummaryCode c(s, range, unit);
    put_varint(out, c.min);
    put_varint(out, c.span);
    put_varint(out, c.delta);
}

SummaryValues get_summary(ByteParser& in, const SummaryRange& range, std::int64_t unit) {
    const std::int64_t min = floor_to(range.min, unit) + std::int64_t{in.varint()} * unit;
    const std::int64_t max = min + std::int64_t{in.varint()} * unit;
    const std::uint32_t below = in.varint();
    if (min > INT32_MAX || max > std::int64_t{INT32_MAX} + unit ||
        below > static_cast<std::uint32_t>(range.delta))
        in.fail("has an impossible summary");
    return {static_cast<std::int32_t>(min), static_cast<std::int32_t>(std::min(max, std::int64_t{INT32_MAX})),
            delta_of_index(range.delta - static_cast<int>(below))};
}

}  // namespace carat
