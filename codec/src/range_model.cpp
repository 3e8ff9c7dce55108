#include "range_model.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

namespace carat {

RangeTables::Model::Model(const Frequencies& f)
    : cutoff(kContexts * kTokens), entries(kContexts * kTokens), frequency(f) {
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
        const auto entry = [&](std::size_t token, int shift) {
            return static_cast<std::uint32_t>(token) | std::uint32_t{f[token]} << 6 |
                   (static_cast<std::uint32_t>(shift) & (kFrequencySum - 1)) << 18;
        };
        cutoff[at + b] = static_cast<std::uint8_t>(share[b]);
        entries[at + b] = {entry(b, 0), entry(static_cast<std::size_t>(alias[b]), offset[b])};
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
            const double cost = escapes ? bits(kEscape) + raw_bits(kEscape) : bits(t) + raw_bits(t);
            encoder_.cost[at] = static_cast<std::uint16_t>(std::lround(256 * cost));
        }
        for (std::size_t x = 0; x < kFrequencySum; ++x) {
            const std::size_t at = c * kTokens + (x >> kBucketBits), inside = x & (kBucketSize - 1);
            const std::uint32_t e = entries[at][inside >= cutoff[at] ? 1 : 0];
            const std::size_t number = (inside + (e >> 18)) & (kFrequencySum - 1);
            encoder_.slot[c * kFrequencySum + encoder_.begin[c * kTokens + (e & 63)] + number] =
                static_cast<std::uint16_t>(x);
        }
    }
}

}  // namespace carat
