#include "page.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "file_header.hpp"

namespace carat {
namespace {

constexpr int kDeepestRefined = kDeepestId - 1;

// Level of a slot's diamonds within their page.
int sub_level(int slot) {
    int j = 0;
    while (slot >= first_slot(j + 1)) ++j;
    return j;
}

std::vector<std::byte> with_checksum(const std::vector<std::byte>& body) {
    std::vector<std::byte> out;
    out.reserve(body.size() + 8);
    put(out, checksum_of(body));
    out.insert(out.end(), body.begin(), body.end());
    return out;
}

}  // namespace

std::string page_name(PageKey key) {
    const std::optional<DiamondId> square = page_square(key);
    return square ? "page " + to_string(*square) : "page with impossible key " + std::to_string(key);
}

SummaryRange range_of(std::span<const PageDiamond> diamonds) {
    SummaryRange r;
    for (const PageDiamond& d : diamonds)
        for (const SummaryValues& s : d.summary) r.include(s);
    return r;
}

std::size_t part_cost(PageKey key, const PageDiamond& d, const SummaryRange& range, const SummaryGrid& grid) {
    const std::int64_t unit = grid.unit(page_square(key)->level() + sub_level(d.slot));
    std::size_t bytes = 1 + varint_bytes(d.blob.size()) + d.blob.size();
    for (const SummaryValues& s : d.summary) bytes += summary_bytes(s, range, unit);
    return bytes;
}

std::vector<std::byte> encode_part(PageKey key, int first_slot, int slots,
                                   std::span<const PageDiamond> diamonds, const SummaryRange& range,
                                   const SummaryGrid& grid) {
    std::vector<std::byte> body;
    body.reserve(kMaxPartBytes);
    put(body, key);
    put(body, static_cast<std::uint8_t>(PageKind::diamonds));
    put(body, static_cast<std::uint8_t>(first_slot));
    put(body, static_cast<std::uint8_t>(slots));
    put(body, std::uint8_t{0});
    put(body, range.min);
    put(body, static_cast<std::uint16_t>(range.delta));
    put(body, std::uint16_t{0});
    std::vector<std::byte> bitmap(static_cast<std::size_t>((slots + 7) / 8));
    for (const PageDiamond& d : diamonds) {
        const int k = d.slot - first_slot;
        assert(k >= 0 && k < slots);
        bitmap[static_cast<std::size_t>(k / 8)] |= static_cast<std::byte>(1 << (k % 8));
    }
    body.insert(body.end(), bitmap.begin(), bitmap.end());
    const int first_level = page_square(key)->level();
    for (const PageDiamond& d : diamonds) {
        put(body, d.info.to_byte());
        for (const SummaryValues& s : d.summary)
            put_summary(body, s, range, grid.unit(first_level + sub_level(d.slot)));
        put_varint(body, d.blob.size());
    }
    for (const PageDiamond& d : diamonds) body.insert(body.end(), d.blob.begin(), d.blob.end());
    return with_checksum(body);
}

std::vector<std::byte> encode_zero_page(PageKey key, const ZeroSpan& zero) {
    std::vector<std::byte> body;
    body.reserve(kMaxPartBytes);
    put(body, key);
    put(body, static_cast<std::uint8_t>(PageKind::zero));
    put(body, static_cast<std::uint8_t>(zero.end_level));
    put(body, std::uint16_t{0});
    put(body, zero.min);
    put(body, zero.max);
    for (const double d : zero.delta) put(body, static_cast<std::uint16_t>(index_of_delta(d)));
    return with_checksum(body);
}

PagePart::PagePart(std::vector<std::byte> bytes, PageKey key, int first_slot, const std::string& file,
                   const SummaryGrid& grid)
    : bytes_(std::move(bytes)) {
    index_.fill(-1);
    ByteParser in(bytes_, file + ": " + page_name(key));
    const std::optional<DiamondId> square = page_square(key);
    if (!square) in.fail("is in the directory");
    const auto checksum = in.get<std::uint64_t>();
    if (checksum != checksum_of(std::span<const std::byte>(bytes_).subspan(8))) in.fail("fails its checksum");
    if (in.get<std::uint64_t>() != key) in.fail("holds another page's bytes");
    const auto kind = in.get<std::uint8_t>();
    if (kind > 1) in.fail("is of an unknown kind");
    kind_ = static_cast<PageKind>(kind);
    first_slot_ = first_slot;
    if (kind_ == PageKind::zero)
        parse_zero(in, *square);
    else
        parse_diamonds(in, *square, grid);
    if (in.left() != 0) in.fail("has bytes left over");
}

void PagePart::parse_zero(ByteParser& in, DiamondId square) {
    if (first_slot_ != 0) in.fail("is a zero page in parts");
    zero_.end_level = in.get<std::uint8_t>();
    if (in.get<std::uint16_t>() != 0) in.fail("has a reserved field that is not zero");
    if (zero_.end_level <= square.level() || zero_.end_level > kDeepestId)
        in.fail("has an impossible end level");
    zero_.min = in.get<std::int32_t>();
    zero_.max = in.get<std::int32_t>();
    if (zero_.min > zero_.max) in.fail("has an impossible summary range");
    for (int l = square.level(); l < zero_.end_level; ++l) {
        const int index = in.get<std::uint16_t>();
        if (index > kGreatestDeltaIndex) in.fail("has an impossible delta");
        zero_.delta.push_back(delta_of_index(index));
    }
}

void PagePart::parse_diamonds(ByteParser& in, DiamondId square, const SummaryGrid& grid) {
    const int first = in.get<std::uint8_t>(), slots = in.get<std::uint8_t>();
    if (in.get<std::uint8_t>() != 0) in.fail("has a reserved field that is not zero");
    if (first != first_slot_ || slots == 0 || first + slots > kPageSlots) in.fail("has impossible slots");
    end_slot_ = first + slots;
    SummaryRange range;
    range.min = in.get<std::int32_t>();
    range.delta = in.get<std::uint16_t>();
    if (range.delta > kGreatestDeltaIndex) in.fail("has an impossible delta");
    if (in.get<std::uint16_t>() != 0) in.fail("has a reserved field that is not zero");
    const auto bitmap = in.take(static_cast<std::size_t>((slots + 7) / 8));
    std::vector<std::uint32_t> lengths;
    for (int k = 0; k < static_cast<int>(bitmap.size()) * 8; ++k) {
        if ((static_cast<unsigned>(bitmap[static_cast<std::size_t>(k / 8)]) >> (k % 8) & 1) == 0) continue;
        if (k >= slots) in.fail("marks slots it does not have");
        if (square.level() + sub_level(first + k) > kDeepestRefined)
            in.fail("refines beyond the deepest level");
        PageDiamond d;
        d.slot = first + k;
        index_[static_cast<std::size_t>(d.slot)] = static_cast<std::int8_t>(diamonds_.size());
        diamonds_.push_back(d);
    }
    for (PageDiamond& d : diamonds_) {
        d.info = BlobInfo::from_byte(in.get<std::uint8_t>());
        const std::int64_t unit = grid.unit(square.level() + sub_level(d.slot));
        for (SummaryValues& s : d.summary) s = get_summary(in, range, unit);
        lengths.push_back(in.varint());
    }
    for (std::size_t k = 0; k < diamonds_.size(); ++k) diamonds_[k].blob = in.take(lengths[k]);
}

const PageDiamond* PagePart::find(int slot) const {
    const int at = index_[static_cast<std::size_t>(slot)];
    return at < 0 ? nullptr : &diamonds_[static_cast<std::size_t>(at)];
}

}  // namespace carat
