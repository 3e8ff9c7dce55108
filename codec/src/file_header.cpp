#include "file_header.hpp"

#include <xxhash.h>

#include <algorithm>
#include <cmath>

namespace carat {
namespace {

void put_text(std::vector<std::byte>& out, const std::string& text) {
    for (const char c : text) out.push_back(static_cast<std::byte>(c));
}

Extent get_extent(ByteParser& in) {
    Extent e;
    e.offset = in.get<std::uint64_t>();
    e.bytes = in.get<std::uint32_t>();
    if (in.get<std::uint32_t>() != 0) in.fail("has a reserved field that is not zero");
    e.checksum = in.get<std::uint64_t>();
    return e;
}

void put_extent(std::vector<std::byte>& out, const Extent& e) {
    put(out, e.offset);
    put(out, e.bytes);
    put(out, std::uint32_t{0});
    put(out, e.checksum);
}

void check_extent(const ByteParser& in, const Extent& e, std::uint64_t file_bytes, const char* name) {
    if (e.offset > file_bytes || e.bytes > file_bytes - e.offset)
        in.fail(std::string("places its ") + name + " outside the file");
}

void check_values(const ByteParser& in, const FileHeader& h) {
    const RepositoryHeader& i = h.info;
    const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
    if (i.log2_cells < 2 || i.log2_cells > 7) in.fail("has an unsupported patch size");
    if (!positive(i.quantum) || !positive(i.tolerance) || i.tolerance < i.quantum / 2)
        in.fail("has an impossible quantum or tolerance");
    if (!(i.body_b <= i.body_a && i.body_b >= i.body_a / kMostOblate && i.body_a >= kLeastAxis &&
          i.body_a <= kGreatestAxis))
        in.fail("has an impossible body");
    if (i.deepest_level < 0 || i.deepest_level > std::min(kDeepestId, deepest_level(i.log2_cells)))
        in.fail("has an impossible depth");
    if (h.radii.size() != static_cast<std::size_t>(i.deepest_level) + 1)
        in.fail("has a wrong number of radii");
    for (const std::int32_t r : h.radii)
        if (r < 0 || r > (1 << 29) || r * i.quantum + i.quantum / 2 > i.tolerance)
            in.fail("has a quantiser radius that breaks its tolerance");
    if (i.min_height > i.max_height) in.fail("has an impossible height range");
    if (!(i.rms_tolerance >= 0 && i.rms_tolerance <= i.tolerance)) in.fail("has an impossible RMS tolerance");
}

void set_tables(const ByteParser& in, FileHeader& h) {
    h.info.fitted_tables = !h.tables.empty();
    if (h.coding.coder == CoderId::gamma) {
        if (h.info.fitted_tables) in.fail("has tables that its coder does not use");
        h.coding.tables = nullptr;
    } else if (h.info.fitted_tables) {
        try {
            h.coding.tables = RangeTables::parse(h.tables);
        } catch (const Error& e) {
            in.fail(std::string("has unusable tables of its coder: ") + e.what());
        }
    }
}

}  // namespace

std::uint64_t checksum_of(std::span<const std::byte> bytes) {
    return XXH3_64bits(bytes.data(), bytes.size());
}

std::vector<std::byte> FileHeader::to_bytes() const {
    std::vector<std::byte> out;
    for (const std::uint8_t c : kMagic) put(out, c);
    put(out, kFormatVersion);
    const std::size_t total = kFixedHeaderBytes + 4 * radii.size() + info.body.size() +
                              info.vertical_datum.size() + info.provenance.size() + tables.size() + 8;
    put(out, static_cast<std::uint32_t>(total));
    put(out, file_bytes);
    put(out, info.quantum);
    put(out, info.tolerance);
    put(out, info.body_a);
    put(out, info.body_b);
    put(out, static_cast<std::uint8_t>(info.log2_cells));
    put(out, static_cast<std::uint8_t>(coding.coder));
    put(out, std::uint8_t{0});  // attribute: relief
    put(out, static_cast<std::uint8_t>(info.deepest_level));
    put(out, static_cast<std::uint32_t>(radii.size()));
    put(out, info.refined_diamonds);
    put(out, info.min_height);
    put(out, info.max_height);
    put_extent(out, roots);
    put_extent(out, directory);
    put(out, static_cast<std::uint32_t>(info.body.size()));
    put(out, static_cast<std::uint32_t>(info.vertical_datum.size()));
    put(out, static_cast<std::uint32_t>(info.provenance.size()));
    put(out, static_cast<std::uint32_t>(tables.size()));
    put(out, info.rms_tolerance);
    for (const std::int32_t r : radii) put(out, r);
    put_text(out, info.body);
    put_text(out, info.vertical_datum);
    put_text(out, info.provenance);
    out.insert(out.end(), tables.begin(), tables.end());
    put(out, checksum_of(out));
    return out;
}

std::uint32_t parse_header_length(std::span<const std::byte> first16, const std::string& file) {
    ByteParser in(first16, file + ": header");
    for (const std::uint8_t c : kMagic)
        if (in.get<std::uint8_t>() != c)
            throw Error(ErrorCode::corrupt, file + ": not a Carat repository (wrong magic number)");
    const auto version = in.get<std::uint32_t>();
    if (version != kFormatVersion)
        throw Error(ErrorCode::unsupported, file + ": format version " + std::to_string(version) +
                                                "; this build reads version " +
                                                std::to_string(kFormatVersion));
    const auto length = in.get<std::uint32_t>();
    if (length < kFixedHeaderBytes + 8) in.fail("is shorter than a header can be");
    if (length > kMaxHeaderBytes) throw Error(ErrorCode::limit, file + ": header above 16 MiB");
    return length;
}

FileHeader parse_header(std::span<const std::byte> bytes, const std::string& file, std::uint64_t file_bytes) {
    ByteParser in(bytes.first(bytes.size() - 8), file + ": header");
    ByteParser tail(bytes.last(8), file + ": header");
    if (tail.get<std::uint64_t>() != checksum_of(bytes.first(bytes.size() - 8)))
        in.fail("fails its checksum");
    in.take(16);
    FileHeader h;
    h.info.format_version = kFormatVersion;
    h.file_bytes = in.get<std::uint64_t>();
    if (file_bytes < h.file_bytes)
        throw Error(ErrorCode::truncated, file + ": is " + std::to_string(file_bytes) +
                                              " bytes long and should be " + std::to_string(h.file_bytes));
    if (file_bytes > h.file_bytes) throw Error(ErrorCode::corrupt, file + ": has bytes after its end");
    h.info.quantum = in.get<double>();
    h.info.tolerance = in.get<double>();
    h.info.body_a = in.get<double>();
    h.info.body_b = in.get<double>();
    h.info.log2_cells = in.get<std::uint8_t>();
    const auto coder = in.get<std::uint8_t>();
    const auto attribute = in.get<std::uint8_t>();
    if (coder > static_cast<std::uint8_t>(CoderId::range))
        throw Error(ErrorCode::unsupported, file + ": coder id " + std::to_string(coder) + " is unknown");
    if (attribute != 0)
        throw Error(ErrorCode::unsupported,
                    file + ": attribute " + std::to_string(attribute) + " is unknown");
    h.coding.coder = static_cast<CoderId>(coder);
    h.info.coder = to_string(h.coding.coder);
    h.info.deepest_level = in.get<std::uint8_t>();
    const auto radii = in.get<std::uint32_t>();
    h.info.refined_diamonds = in.get<std::uint64_t>();
    h.info.min_height = in.get<std::int32_t>();
    h.info.max_height = in.get<std::int32_t>();
    h.roots = get_extent(in);
    h.directory = get_extent(in);
    const auto body = in.get<std::uint32_t>(), datum = in.get<std::uint32_t>(),
               json = in.get<std::uint32_t>(), tables = in.get<std::uint32_t>();
    h.info.rms_tolerance = in.get<double>();
    if (radii > in.left() / 4) in.fail("has a wrong number of radii");
    for (std::uint32_t k = 0; k < radii; ++k) h.radii.push_back(in.get<std::int32_t>());
    h.info.body = in.text(body);
    h.info.vertical_datum = in.text(datum);
    h.info.provenance = in.text(json);
    const std::span<const std::byte> table_bytes = in.take(tables);
    h.tables.assign(table_bytes.begin(), table_bytes.end());
    if (in.left() != 0) in.fail("has bytes left over");
    check_extent(in, h.roots, file_bytes, "root values");
    check_extent(in, h.directory, file_bytes, "directory");
    check_values(in, h);
    set_tables(in, h);
    return h;
}

void put(std::vector<std::byte>& out, const PartEntry& e) {
    put(out, e.key);
    put(out, e.offset);
    put(out, e.bytes);
    put(out, e.first_slot);
    put(out, std::uint16_t{0});
}

void put(std::vector<std::byte>& out, const BlockEntry& e) {
    put(out, e.first_key);
    put(out, e.first_slot);
    put(out, std::uint16_t{0});
    put(out, e.entries);
    put(out, e.offset);
    put(out, e.checksum);
}

PartEntry get_part_entry(ByteParser& in) {
    PartEntry e;
    e.key = in.get<std::uint64_t>();
    e.offset = in.get<std::uint64_t>();
    e.bytes = in.get<std::uint32_t>();
    e.first_slot = in.get<std::uint16_t>();
    if (in.get<std::uint16_t>() != 0) in.fail("has a reserved field that is not zero");
    return e;
}

BlockEntry get_block_entry(ByteParser& in) {
    BlockEntry e;
    e.first_key = in.get<std::uint64_t>();
    e.first_slot = in.get<std::uint16_t>();
    if (in.get<std::uint16_t>() != 0) in.fail("has a reserved field that is not zero");
    e.entries = in.get<std::uint32_t>();
    e.offset = in.get<std::uint64_t>();
    e.checksum = in.get<std::uint64_t>();
    return e;
}

}  // namespace carat
