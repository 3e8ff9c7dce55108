// A part of a page: its index and blobs. docs/format.md, "Pages".
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "bytes.hpp"
#include "carat/codec/diamond_codec.hpp"
#include "page_layout.hpp"
#include "summary_code.hpp"

namespace carat {

enum class PageKind : std::uint8_t { diamonds = 0, zero = 1 };

// One refined diamond of a page, before or after the file.
struct PageDiamond {
    int slot = 0;
    BlobInfo info;
    std::span<const std::byte> blob;
    std::array<SummaryValues, 2> summary;
};

// "All diamonds of this page and of the pages nested in it are refined with zero residuals (mode 0) below
// end_level, and none is refined from end_level on."
struct ZeroSpan {
    int end_level = 0;
    std::int32_t min = INT32_MAX, max = INT32_MIN;  // quanta, of all halves
    std::vector<double> delta;  // greatest delta of any half, by level from the page's own
};

// What the summaries of a page, rounded to the grid, are relative to: in each of its parts the same.
SummaryRange range_of(std::span<const PageDiamond> diamonds);
// Bytes of one part: checksum, key, index, blobs. The summaries are rounded to the grid.
std::vector<std::byte> encode_part(PageKey key, int first_slot, int slots,
                                   std::span<const PageDiamond> diamonds, const SummaryRange& range,
                                   const SummaryGrid& grid);
std::vector<std::byte> encode_zero_page(PageKey key, const ZeroSpan& zero);
// Bytes a diamond adds to a part, for the splitting rule.
std::size_t part_cost(PageKey key, const PageDiamond& d, const SummaryRange& range, const SummaryGrid& grid);
inline constexpr std::size_t kPartHeaderBytes = 28;

// A parsed part. Immutable; owns its bytes.
class PagePart {
  public:
    // Checks the checksum and every field against what the directory said. Throws
    // Error(corrupt|truncated|...).
    PagePart(std::vector<std::byte> bytes, PageKey key, int first_slot, const std::string& file,
             const SummaryGrid& grid);

    bool is_zero_page() const { return kind_ == PageKind::zero; }
    const ZeroSpan& zero() const { return zero_; }
    int first_slot() const { return first_slot_; }
    int end_slot() const { return end_slot_; }
    // The refined diamond in a slot, or nothing.
    const PageDiamond* find(int slot) const;
    const std::vector<PageDiamond>& diamonds() const { return diamonds_; }
    std::size_t bytes() const { return bytes_.size(); }

  private:
    void parse_diamonds(ByteParser& in, DiamondId square, const SummaryGrid& grid);
    void parse_zero(ByteParser& in, DiamondId square);

    std::vector<std::byte> bytes_;
    PageKind kind_ = PageKind::diamonds;
    int first_slot_ = 0, end_slot_ = kPageSlots;
    ZeroSpan zero_;
    std::vector<PageDiamond> diamonds_;
    std::array<std::int8_t, kPageSlots> index_{};  // slot -> position in diamonds_, or -1
};

// "page LEVEL/FACE/U/V" for messages.
std::string page_name(PageKey key);

}  // namespace carat
