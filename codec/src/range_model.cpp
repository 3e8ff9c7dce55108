#include "range_model.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace carat {

RangeTables::Model::Model(const Frequencies& f)
    : buckets{std::vector<std::uint32_t>(kContexts * kTokens),
              std::vector<std::uint32_t>(kContexts * kTokens)},
      frequency(f) {
    for (int context = 0; context < kContexts; ++context) make_aliases(context);
}

// docs/format.md fixes this order: it decides which slot is whose.
void RangeTables::Model::make_aliases(int context) {
    const auto& f = frequency[static_cast<std::size_t>(context)];
    const std::size_t at = static_cast<std::size_t>(context) * kTokens;
    std::array<int, kTokens> share{}, alias{}, offset{};
    std::vector<int> under, over;
    for (int t = 0; t < kTokens; ++t) {
        share[static_cast<std::size_t>(t)] = f[static_cast<std::size_t>(t)];
        alias[static_cast<std::size_t>(t)] = t;
        if (f[static_cast<std::size_t>(t)] < kBucketSize) under.push_back(t);
        if (f[static_cast<std::size_t>(t)] > kBucketSize) over.push_back(t);
    }
    while (!over.empty()) {
        const auto o = static_cast<std::size_t>(over.back()), u = static_cast<std::size_t>(under.back());
        over.pop_back();
        under.pop_back();
        share[o] -= kBucketSize - share[u];
        alias[u] = static_cast<int>(o);
        offset[u] = share[o] - share[u];
        if (share[o] < kBucketSize) under.push_back(static_cast<int>(o));
        if (share[o] > kBucketSize) over.push_back(static_cast<int>(o));
    }
    for (std::size_t b = 0; b < kTokens; ++b) {
        const auto other = static_cast<std::size_t>(alias[b]);
        buckets.split[at + b] = static_cast<std::uint32_t>(f[b]) | std::uint32_t{f[other]} << 12 |
                                static_cast<std::uint32_t>(share[b]) << 24;
        buckets.alias[at + b] = static_cast<std::uint32_t>(other) | static_cast<std::uint32_t>(offset[b])
                                                                        << 6;
    }
}

const RangeTables::Model::Encoder& RangeTables::Model::encoder() const {
    std::call_once(made_, [this] { make_encoder(); });
    return encoder_;
}

void RangeTables::Model::make_encoder() const {
    encoder_.slot.resize(std::size_t{kContexts} * kFrequencySum);
    encoder_.begin.resize(kContexts * kTokens);
    encoder_.cost.resize(kContexts * kTokens);
    for (std::size_t c = 0; c < kContexts; ++c) {
        std::uint16_t begin = 0;
        const auto bits = [&](int t) {
            return kFrequencyBits - std::log2(frequency[c][static_cast<std::size_t>(t)]);
        };
        for (int t = 0; t < kTokens; ++t) {
            const std::size_t at = c * kTokens + static_cast<std::size_t>(t);
            encoder_.begin[at] = begin;
            begin = static_cast<std::uint16_t>(begin + frequency[c][static_cast<std::size_t>(t)]);
            const bool escapes = frequency[c][static_cast<std::size_t>(t)] == 0;
            const double cost =
                (t == 0 ? 0 : 1) + (escapes ? bits(kEscape) + raw_bits(kEscape) : bits(t) + raw_bits(t));
            encoder_.cost[at] = static_cast<std::uint16_t>(std::lround(256 * cost));
        }
        for (std::size_t x = 0; x < kFrequencySum; ++x) {
            const std::size_t at = c * kTokens + (x >> kBucketBits), inside = x & (kBucketSize - 1);
            const bool own = inside < buckets.split[at] >> 24;
            const std::size_t token = own ? x >> kBucketBits : buckets.alias[at] & (kTokens - 1);
            const std::size_t number =
                own ? inside
                    : inside + static_cast<std::size_t>(static_cast<std::int32_t>(buckets.alias[at]) >> 6);
            encoder_.slot[c * kFrequencySum + encoder_.begin[c * kTokens + token] + number] =
                static_cast<std::uint16_t>(x);
        }
    }
}

}  // namespace carat
