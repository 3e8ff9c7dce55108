// Choices of coding that a whole file shares, and the tables of the range coder.
//
//   coder    gamma: zero-quadtree with Elias-gamma leaves, fast; range: static context model with rANS, small
//   orders   which predictors an encoder may choose among, diamond by diamond
//   tables   frequencies of the range coder: built in, or fitted to a data set and stored in its file
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

namespace carat {

enum class CoderId : std::uint8_t { gamma = 0, range = 1 };
const char* to_string(CoderId coder);

// Prediction of cell centres: Neville lifting of order 2, 4 or 6 (Kovacevic and Sweldens 2000). Values as in
// the file.
enum class Order : std::uint8_t { two = 0, four = 1, six = 2 };
inline constexpr int kOrders = 3;

// How often each token came in each context. Not thread-safe: one per thread, merged at the end.
class RangeStatistics {
  public:
    RangeStatistics();
    // 0 <= context < 128 (asserted only): 64 by activity, and 64 more in the second pass; 0 <= token < 64.
    // docs/format.md, 8.4 and 8.6. Sums of `times` must stay below 2^64.
    void add(std::size_t context, std::size_t token, std::uint64_t times = 1);
    void merge(const RangeStatistics& other);
    std::span<const std::uint64_t> counts() const { return counts_; }  // context * 64 + token

  private:
    std::vector<std::uint64_t> counts_;
};

// Immutable; all functions are thread-safe.
class RangeTables {
  public:
    // The tables of coder id 1: trained on terrain of the Earth and Mars at 0.1 to 16 m; never change.
    static std::shared_ptr<const RangeTables> built_in();
    // Fits frequencies to what was counted; contexts that were seldom seen lean on the built-in ones.
    static std::shared_ptr<const RangeTables> fit(const RangeStatistics& statistics);
    // Reads what bytes() wrote. Throws Error(corrupt|truncated).
    static std::shared_ptr<const RangeTables> parse(std::span<const std::byte> bytes);
    // Bits that the counted tokens take with these tables, signs and raw bits included.
    double bits(const RangeStatistics& statistics) const;
    // docs/format.md, 8.5, "Frequencies and slots".
    std::vector<std::byte> bytes() const;

    struct Model;  // src/range_model.hpp
    explicit RangeTables(std::unique_ptr<const Model> model);
    ~RangeTables();
    const Model& model() const { return *model_; }

  private:
    std::unique_ptr<const Model> model_;
};

// How residuals are coded; the same for all diamonds of a file but for `orders`, which only an encoder reads.
struct Coding {
    CoderId coder = CoderId::range;
    std::shared_ptr<const RangeTables> tables = RangeTables::built_in();  // range only
    unsigned orders = 0b111;  // bit k: the encoder may use Order k; at least one

    static Coding gamma() { return {CoderId::gamma, nullptr, 0b111}; }
    // Order 4 alone with gamma: the C-BDAM paper's coder.
    static Coding paper() { return {CoderId::gamma, nullptr, 0b010}; }
};

}  // namespace carat
