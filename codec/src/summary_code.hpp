// Summaries in a page: varints a half, relative to the part's own least height and greatest delta. Integers
// decide.
#pragma once

#include <cstdint>
#include <vector>

#include "bytes.hpp"
#include "carat/codec/summary.hpp"

namespace carat {

// delta(k) = U[k % 16] / 2^16 * 2^(k / 16 - 40) metres, U[k] = ceil(2^16 * 2^(k/16)); strictly ascending in
// k.
inline constexpr int kGreatestDeltaIndex = 2047;
double delta_of_index(int index);
// Least index whose delta is at least the given one; kGreatestDeltaIndex if none is.
int index_of_delta(double delta);

// What the summaries of a part are relative to.
struct SummaryRange {
    std::int32_t min = INT32_MAX, max = INT32_MIN;  // quanta
    int delta = 0;                                  // greatest index

    void include(const SummaryValues& s);
};

// Bytes that put_summary() appends.
std::size_t summary_bytes(const SummaryValues& s, const SummaryRange& range, std::int64_t unit);
// s: as SummaryGrid::rounded() made it, unit that of its level; within the range.
void put_summary(std::vector<std::byte>& out, const SummaryValues& s, const SummaryRange& range,
                 std::int64_t unit);
// Throws Error(corrupt|truncated) by `in`.
SummaryValues get_summary(ByteParser& in, const SummaryRange& range, std::int64_t unit);

}  // namespace carat
