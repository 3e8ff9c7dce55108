#include <algorithm>
#include <cassert>
#include <cmath>

#include "bits.hpp"
#include "carat/codec/coding.hpp"
#include "gamma_code.hpp"
#include "range_built_in.hpp"
#include "range_model.hpp"

namespace carat {
namespace {

using Frequencies = RangeTables::Model::Frequencies;

// How much a context that was seldom seen leans on the built-in tables: as if they had been seen this often.
constexpr double kPriorWeight = 24;

// Integers near 4096 p[t] that sum to 4096: 0 where p is below half a unit, at least 1 for the escape; what
// rounding leaves over goes to the most frequent token.
std::array<std::uint16_t, kTokens> to_frequencies(const std::array<double, kTokens>& p) {
    std::array<std::uint16_t, kTokens> f{};
    int sum = 0;
    std::size_t top = 0;
    for (std::size_t t = 0; t < kTokens; ++t) {
        double x = std::floor(p[t] * kFrequencySum + 0.5);
        if (t == kEscape) x = std::max(x, 1.0);
        f[t] = static_cast<std::uint16_t>(std::min(x, kFrequencySum - 1.0));
        sum += f[t];
        if (t != kEscape && f[t] >= f[top]) top = t;
    }
    assert(f[top] + kFrequencySum - sum > 0);
    f[top] = static_cast<std::uint16_t>(f[top] + kFrequencySum - sum);
    return f;
}

}  // namespace

const char* to_string(CoderId coder) { return coder == CoderId::gamma ? "gamma" : "range"; }

RangeStatistics::RangeStatistics() : counts_(std::size_t{kContexts} * kTokens) {}
void RangeStatistics::add(std::size_t context, std::size_t token, std::uint64_t times) {
    assert(context < kContexts && token < kTokens);
    counts_[context * kTokens + token] += times;
}
void RangeStatistics::merge(const RangeStatistics& other) {
    for (std::size_t k = 0; k < counts_.size(); ++k) counts_[k] += other.counts_[k];
}

RangeTables::RangeTables(std::unique_ptr<const Model> model) : model_(std::move(model)) {}
RangeTables::~RangeTables() = default;

std::shared_ptr<const RangeTables> RangeTables::built_in() {
    static const std::shared_ptr<const RangeTables> tables =
        parse(std::as_bytes(std::span<const std::uint8_t>(kBuiltInRangeTables)));
    return tables;
}

std::shared_ptr<const RangeTables> RangeTables::fit(const RangeStatistics& statistics) {
    const Frequencies& prior = built_in()->model().frequency;
    Frequencies f{};
    for (std::size_t c = 0; c < kContexts; ++c) {
        const std::uint64_t* n = statistics.counts().data() + c * kTokens;
        double total = kPriorWeight;
        for (std::size_t t = 0; t < kTokens; ++t) total += static_cast<double>(n[t]);
        std::array<double, kTokens> p{};
        for (std::size_t t = 0; t < kTokens; ++t)
            p[t] = (static_cast<double>(n[t]) + kPriorWeight * prior[c][t] / kFrequencySum) / total;
        f[c] = to_frequencies(p);
    }
    return std::make_shared<RangeTables>(std::make_unique<Model>(f));
}

double RangeTables::bits(const RangeStatistics& statistics) const {
    const std::vector<std::uint16_t>& cost = model_->encoder().cost;
    double sum = 0;
    for (std::size_t k = 0; k < cost.size(); ++k)
        sum += static_cast<double>(statistics.counts()[k]) * cost[k] / 256;
    return sum;
}

// By context: one bit, 0: as the context before; 1: six bits K, then for the tokens below K the gamma code of
// the frequency less that of the context before (of the first: of zero); from K to the escape 0; the escape
// has what is left of 4096.
std::vector<std::byte> RangeTables::bytes() const {
    BitWriter out;
    std::array<std::uint16_t, kTokens> before{};
    for (const auto& f : model_->frequency) {
        out.put(f == before ? 0 : 1, 1);
        if (f == before) continue;
        int k = kEscape;
        while (k > 0 && f[static_cast<std::size_t>(k - 1)] == 0) --k;
        out.put(static_cast<std::uint64_t>(k), 6);
        for (std::size_t t = 0; t < static_cast<std::size_t>(k); ++t) put_gamma(out, f[t] - before[t]);
        before = f;
    }
    return out.finish();
}

std::shared_ptr<const RangeTables> RangeTables::parse(std::span<const std::byte> bytes) {
    BitReader in(bytes);
    Frequencies all{};
    std::array<std::uint16_t, kTokens> f{};
    for (std::size_t c = 0; c < kContexts; ++c) {
        in.refill();
        if (in.take(1) != 0) {
            const auto k = static_cast<std::size_t>(in.take(6));
            std::int64_t left = kFrequencySum;
            for (std::size_t t = 0; t < kEscape; ++t) {
                const std::int64_t value = t < k ? std::int64_t{f[t]} + take_gamma(in) : 0;
                if (value < 0 || value >= left)
                    throw Error(ErrorCode::corrupt, "impossible frequency of a token");
                left -= value;
                f[t] = static_cast<std::uint16_t>(value);
            }
            f[kEscape] = static_cast<std::uint16_t>(left);
        }
        if (f[kEscape] == 0) throw Error(ErrorCode::corrupt, "a context without frequencies");
        if (f[kEscape] == kFrequencySum) throw Error(ErrorCode::corrupt, "a context of nothing but escapes");
        all[c] = f;
    }
    in.finish();
    return std::make_shared<RangeTables>(std::make_unique<Model>(all));
}

}  // namespace carat
