#include "targets.hpp"

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/diamond_codec.hpp"
#include "carat/globe/error.hpp"
#include "codec/checksum_repair.hpp"
#include "codec/walk.hpp"
#include "directory.hpp"
#include "file_header.hpp"
#include "page.hpp"

namespace carat::fuzz {
namespace {

using Bytes = std::vector<std::byte>;

[[noreturn]] void broken(const char* promise) {
    std::fprintf(stderr, "broken promise: %s\n", promise);
    std::abort();
}

// Runs the action; typed errors of damage are right answers, all else is a finding.
template <class Action>
bool accepted(Action action) {
    try {
        action();
        return true;
    } catch (const Error& e) {
        if (e.code() == ErrorCode::io || e.code() == ErrorCode::usage)
            broken("damage is neither io nor usage");
        return false;
    }
}

int number(std::span<const std::byte> input, std::size_t at) { return static_cast<int>(input[at]); }

void put_checksum(Bytes& bytes, std::size_t at, std::span<const std::byte> of) {
    const std::uint64_t sum = checksum_of(of);
    std::memcpy(bytes.data() + at, &sum, 8);
}

std::vector<std::int32_t> vertices(int n, std::uint32_t seed) {
    std::vector<std::int32_t> p(static_cast<std::size_t>(n * n));
    for (auto& x : p) {
        seed = seed * 1664525u + 1013904223u;
        x = static_cast<std::int32_t>(seed) >> (seed % 31);
    }
    return p;
}

// Sides of matrices: small ones are quick and reach nearly everything.
constexpr int kSides[] = {5, 5, 5, 9, 9, 9, 17, 17, 5, 9, 5, 9, 17, 33, 33, 65};

// 8 bytes of settings, then a blob: see targets.hpp.
void blob(const Coding& coding, std::span<const std::byte> input) {
    if (input.size() < 8) return;
    const bool gamma = coding.coder == CoderId::range && (number(input, 0) & 128) != 0;
    const int leaf = (gamma || coding.coder == CoderId::gamma) && (number(input, 0) & 4) != 0 ? 4 : 2;
    const BlobInfo info{static_cast<Mode>(number(input, 0) % 3), leaf, gamma,
                        static_cast<Order>((number(input, 0) >> 3) % kOrders)};
    const int n = kSides[number(input, 1) % 16];
    std::uint32_t raw_radius = 0;
    std::memcpy(&raw_radius, input.data() + 2, 4);
    const auto radius = static_cast<std::int32_t>(raw_radius % ((1u << 29) + 1));
    const auto p = vertices(n, static_cast<std::uint32_t>(number(input, 6) | number(input, 7) << 8));
    CodecScratch scratch;
    RefinedHeights decoded, encoded, again;
    if (!accepted([&] { decode_residuals(coding, info, input.subspan(8), p, n, radius, decoded, scratch); }))
        return;
    const EncodedResiduals e = encode_residuals(coding, info.mode, p, decoded, radius, encoded, scratch);
    decode_residuals(coding, e.info, e.blob, p, n, radius, again, scratch);
    if (again.v != encoded.v || again.c != encoded.c) broken("decoding repeats encoding");
}

}  // namespace

void gamma_blob(std::span<const std::byte> input) { blob(Coding::gamma(), input); }

void range_blob(std::span<const std::byte> input) {
    static const Coding coding;
    blob(coding, input);
}

void tables(std::span<const std::byte> input) {
    accepted([&] {
        const auto parsed = RangeTables::parse(input);
        const Bytes written = parsed->bytes();
        if (RangeTables::parse(written)->bytes() != written)
            broken("tables that are read are written the same");
    });
}

void header(std::span<const std::byte> input) {
    if (input.size() < kFixedHeaderBytes + 8) return;
    Bytes bytes(input.begin(), input.end());
    put_checksum(bytes, bytes.size() - 8, std::span(bytes).first(bytes.size() - 8));
    std::uint64_t file_bytes = 0;
    std::memcpy(&file_bytes, bytes.data() + 16, 8);
    accepted([&] {
        parse_header_length(std::span(bytes).first(16), "fuzz");
        const FileHeader h = parse_header(bytes, "fuzz", file_bytes);
        Bytes same = h.to_bytes();
        const auto length = static_cast<std::uint32_t>(bytes.size());
        std::memcpy(bytes.data() + 12, &length, 4);  // the length field is the caller's to compare
        put_checksum(bytes, bytes.size() - 8, std::span(bytes).first(bytes.size() - 8));
        if (same != bytes) broken("a header that is read is written the same");
    });
}

void page(std::span<const std::byte> input) {
    if (input.size() < 10) return;
    const DiamondId squares[] = {root_diamond(0), slot_diamond(root_diamond(3), 36), root_diamond(5)};
    DiamondId square = squares[number(input, 0) % 3];
    if (square.level() == 4) square = child(child(square, 0), 3);  // a square of level 6
    const PageKey key = page_key(square);
    const int first = number(input, 1) % kPageSlots;
    Bytes part(input.begin() + 2, input.end());
    put_checksum(part, 0, std::span(part).subspan(8));
    if (part.size() >= 16) std::memcpy(part.data() + 8, &key, 8);
    if (part.size() >= 18 && part[16] == std::byte{0}) part[17] = static_cast<std::byte>(first);
    put_checksum(part, 0, std::span(part).subspan(8));
    accepted([&] {
        const SummaryGrid grid(6378137, 1.0 / 256, 3);
        const PagePart parsed(part, key, first, "fuzz", grid);
        for (const PageDiamond& d : parsed.diamonds())
            if (parsed.find(d.slot) != &d || d.slot < first || d.slot >= parsed.end_slot())
                broken("slots are found");
        if (!parsed.is_zero_page() && encode_part(key, first, parsed.end_slot() - first, parsed.diamonds(),
                                                  range_of(parsed.diamonds()), grid)
                                              .size() > part.size())
            broken("a part that is read is written no longer");
    });
}

void directory(std::span<const std::byte> input) {
    if (input.size() < 2) return;
    Bytes bytes(input.begin() + 2, input.end());
    const auto top =
        std::min(bytes.size(), static_cast<std::size_t>(number(input, 0) | number(input, 1) << 8));
    for (std::size_t at = 0; at + kBlockEntryBytes <= top; at += kBlockEntryBytes) {
        std::uint32_t entries = 0;
        std::uint64_t offset = 0;
        std::memcpy(&entries, bytes.data() + at + 12, 4);
        std::memcpy(&offset, bytes.data() + at + 16, 8);
        const std::uint64_t length = std::uint64_t{entries} * kPartEntryBytes;
        if (offset <= bytes.size() && length <= bytes.size() - offset)
            put_checksum(bytes, at + 24, std::span(bytes).subspan(offset, length));
    }
    const auto source = bytes_in_memory(bytes, "fuzz");
    accepted([&] {
        const Directory d(*source, std::span(bytes).first(top));
        for (const PartEntry& e : d.all()) {
            if (e.offset + e.bytes > bytes.size()) broken("parts lie inside the file");
            const auto found = d.find(e.key, e.first_slot);
            if (!found || found->offset != e.offset) broken("what is listed is found");
        }
        d.find(page_key(root_diamond(1)), 5);
    });
}

void repository(std::span<const std::byte> input) {
    Bytes file(input.begin(), input.end());
    test::repair_checksums(file);
    accepted([&] { test::walk(Repository::open(bytes_in_memory(std::move(file), "fuzz")), 300); });
}

}  // namespace carat::fuzz
