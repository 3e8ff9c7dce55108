#include "page.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

#include "file_header.hpp"

namespace carat {
namespace {

constexpr int kDeepestRefined = kDeepestId - 1;

std::size_t varint_bytes(std::size_t value) {
    std::size_t n = 1;
    for (; value >= 0x80; value >>= 7) ++n;
    return n;
}

SummaryRange range_of(std::span<const PageDiamond> diamonds) {
    SummaryRange r{INT32_MAX, INT32_MIN, 0};
    for (const PageDiamond& d : diamonds)
        for (const SummaryValues& s : d.summary) r.include(s);
    return r;
}

void put_range(std::vector<std::byte>& out, const SummaryRange& r) {
    put(out, r.min);
    put(out, r.max);
    put(out, r.delta);
}

SummaryRange get_range(ByteParser& in) {
    SummaryRange r;
    r.min = in.get<std::int32_t>();
    r.max = in.get<std::int32_t>();
    r.delta = in.get<float>();
    if (r.min > r.max || !std::isfinite(r.delta) || r.delta < 0) in.fail("has an impossible summary range");
    return r;
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

std::size_t part_cost(const PageDiamond& d) { return 7 + varint_bytes(d.blob.size()) + d.blob.size(); }

std::vector<std::byte> encode_part(PageKey key, int first_slot, int slots,
                                   std::span<const PageDiamond> diamonds) {
    std::vector<std::byte> body;
    put(body, key);
    put(body, static_cast<std::uint8_t>(PageKind::diamonds));
    put(body, static_cast<std::uint8_t>(first_slot));
    put(body, static_cast<std::uint8_t>(slots));
    put(body, std::uint8_t{0});
    const SummaryRange range = range_of(diamonds);
    put_range(body, range);
    std::vector<std::byte> bitmap(static_cast<std::size_t>((slots + 7) / 8));
    for (const PageDiamond& d : diamonds) {
        const int k = d.slot - first_slot;
        assert(k >= 0 && k < slots);
        bitmap[static_cast<std::size_t>(k / 8)] |= static_cast<std::byte>(1 << (k % 8));
    }
    body.insert(body.end(), bitmap.begin(), bitmap.end());
    for (const PageDiamond& d : diamonds) {
        put(body, d.info.to_byte());
        for (const SummaryValues& s : d.summary) {
            const SummaryCode c = encode_summary(s, range);
            put(body, c.min);
            put(body, c.max);
            put(body, c.delta);
        }
        put_varint(body, d.blob.size());
    }
    for (const PageDiamond& d : diamonds) body.insert(body.end(), d.blob.begin(), d.blob.end());
    return with_checksum(body);
}

std::vector<std::byte> encode_zero_page(PageKey key, const ZeroSpan& zero) {
    std::vector<std::byte> body;
    put(body, key);
    put(body, static_cast<std::uint8_t>(PageKind::zero));
    put(body, static_cast<std::uint8_t>(zero.end_level));
    put(body, std::uint16_t{0});
    put_range(body, zero.range);
    for (const double d : zero.delta) put(body, encode_delta(d, zero.range.delta));
    return with_checksum(body);
}

PagePart::PagePart(std::vector<std::byte> bytes, PageKey key, int first_slot, const std::string& file)
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
        parse_diamonds(in, *square);
    if (in.left() != 0) in.fail("has bytes left over");
}

void PagePart::parse_zero(ByteParser& in, DiamondId square) {
    if (first_slot_ != 0) in.fail("is a zero page in parts");
    zero_.end_level = in.get<std::uint8_t>();
    if (in.get<std::uint16_t>() != 0) in.fail("has a reserved field that is not zero");
    if (zero_.end_level <= square.level() || zero_.end_level > kDeepestId)
        in.fail("has an impossible end level");
    zero_.range = get_range(in);
    for (int l = square.level(); l < zero_.end_level; ++l)
        zero_.delta.push_back(decode_delta(in.get<std::uint8_t>(), zero_.range.delta));
}

void PagePart::parse_diamonds(ByteParser& in, DiamondId square) {
    const int first = in.get<std::uint8_t>(), slots = in.get<std::uint8_t>();
    if (in.get<std::uint8_t>() != 0) in.fail("has a reserved field that is not zero");
    if (first != first_slot_ || slots == 0 || first + slots > kPageSlots) in.fail("has impossible slots");
    end_slot_ = first + slots;
    const SummaryRange range = get_range(in);
    const auto bitmap = in.take(static_cast<std::size_t>((slots + 7) / 8));
    std::vector<std::uint32_t> lengths;
    for (int k = 0; k < static_cast<int>(bitmap.size()) * 8; ++k) {
        if ((static_cast<unsigned>(bitmap[static_cast<std::size_t>(k / 8)]) >> (k % 8) & 1) == 0) continue;
        if (k >= slots) in.fail("marks slots it does not have");
        int j = 0;
        while (first + k >= carat::first_slot(j + 1)) ++j;
        if (square.level() + j > kDeepestRefined) in.fail("refines beyond the deepest level");
        PageDiamond d;
        d.slot = first + k;
        index_[static_cast<std::size_t>(d.slot)] = static_cast<std::int8_t>(diamonds_.size());
        diamonds_.push_back(d);
    }
    for (PageDiamond& d : diamonds_) {
        d.info = BlobInfo::from_byte(in.get<std::uint8_t>());
        for (SummaryValues& s : d.summary) {
            SummaryCode c;
            c.min = in.get<std::uint8_t>();
            c.max = in.get<std::uint8_t>();
            c.delta = in.get<std::uint8_t>();
            s = decode_summary(c, range);
        }
        lengths.push_back(in.varint());
    }
    for (std::size_t k = 0; k < diamonds_.size(); ++k) diamonds_[k].blob = in.take(lengths[k]);
}

const PageDiamond* PagePart::find(int slot) const {
    const int at = index_[static_cast<std::size_t>(slot)];
    return at < 0 ? nullptr : &diamonds_[static_cast<std::size_t>(at)];
}

}  // namespace carat
