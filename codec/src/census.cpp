#include "census.hpp"

#include <algorithm>

#include "roots.hpp"

namespace carat {
namespace {

std::vector<std::byte> read(const ByteSource& source, std::uint64_t offset, std::size_t bytes) {
    std::vector<std::byte> out(bytes);
    source.read(offset, out);
    return out;
}

std::vector<std::byte> read(const ByteSource& source, const Extent& e, const char* what) {
    std::vector<std::byte> out = read(source, e.offset, e.bytes);
    if (checksum_of(out) != e.checksum)
        throw Error(ErrorCode::corrupt, source.name() + ": " + what + " fails its checksum");
    return out;
}

LevelCensus& level_of(FileCensus& census, int level) {
    const auto l = static_cast<std::size_t>(level);
    if (census.levels.size() <= l) census.levels.resize(l + 1);
    return census.levels[l];
}

void count_zero(FileCensus& census, PageKey key, const ZeroSpan& zero) {
    for (int level = page_square(key)->level(); level < zero.end_level; ++level) {
        const std::uint64_t n = nested_diamonds(key, level);
        LevelCensus& l = level_of(census, level);
        l.refined += n;
        l.zero += n;
        census.refined += n;
        census.zero += n;
    }
    ++census.zero_pages;
}

void count_diamonds(FileCensus& census, PageKey key, const PagePart& part) {
    const int first_level = page_square(key)->level();
    for (const PageDiamond& d : part.diamonds()) {
        int j = 0;
        while (d.slot >= first_slot(j + 1)) ++j;
        LevelCensus& l = level_of(census, first_level + j);
        ++l.refined;
        ++census.refined;
        if (d.blob.empty()) {
            ++l.zero;
            ++census.zero;
            continue;
        }
        ++l.modes[static_cast<std::size_t>(d.info.mode)];
        l.coded_bytes += d.blob.size();
        census.coded_bytes += d.blob.size();
    }
}

}  // namespace

FileStructure::FileStructure(const ByteSource& source) : source_(source) {
    constexpr std::size_t kLengthBytes = 16;
    header_bytes_ = parse_header_length(read(source, 0, kLengthBytes), source.name());
    if (header_bytes_ > source.size())
        throw Error(ErrorCode::truncated, source.name() + ": header ends early");
    header_ = parse_header(read(source, 0, header_bytes_), source.name(), source.size());
    decode_roots(read(source, header_.roots, "root values"), header_.info.n(), header_.radii[0],
                 source.name());
    parts_ = Directory(source, read(source, header_.directory, "directory")).all();
    for (const PartEntry& e : parts_)
        if (!page_square(e.key))
            throw Error(ErrorCode::corrupt, source.name() + ": directory: " + page_name(e.key));
}

PagePart FileStructure::part(const PartEntry& entry) const {
    return {read(source_, entry.offset, entry.bytes), entry.key, entry.first_slot, source_.name(),
            header_.grid()};
}

FileCensus FileStructure::empty_census() const {
    FileCensus c;
    c.file_bytes = source_.size();
    c.header_bytes = header_bytes_;
    c.root_bytes = header_.roots.bytes;
    c.directory_bytes = header_.directory.bytes + parts_.size() * kPartEntryBytes;
    return c;
}

void FileStructure::check_layout(const std::function<void(const std::string&)>& remark) const {
    struct Stretch {
        std::uint64_t offset, bytes;
        std::string name;
    };
    std::vector<Stretch> file{{0, header_bytes_, "header"},
                              {header_.roots.offset, header_.roots.bytes, "root values"}};
    for (const PartEntry& e : parts_) file.push_back({e.offset, e.bytes, page_name(e.key)});
    std::stable_sort(file.begin(), file.end(),
                     [](const auto& a, const auto& b) { return a.offset < b.offset; });
    const std::uint64_t blocks =
        parts_.size() * kPartEntryBytes;  // of the directory, ahead of its first level
    const std::uint64_t directory = header_.directory.offset;
    file.push_back(
        {directory >= blocks ? directory - blocks : 0, blocks + header_.directory.bytes, "directory"});
    file.push_back({source_.size(), 0, "end"});
    std::uint64_t end = 0;
    std::string before = "begin";
    for (const Stretch& s : file) {
        if (s.offset < end)
            remark(s.name + " overlaps what lies before it, " + before);
        else if (s.offset > end)
            remark(std::to_string(s.offset - end) + " bytes between " + before + " and " + s.name +
                   " belong to nothing");
        end = std::max(end, s.offset + s.bytes);
        before = s.name;
    }
}

void count(FileCensus& census, const PartEntry& entry, const PagePart& part) {
    ++census.parts;
    census.pages += part.first_slot() == 0 ? 1 : 0;
    census.page_bytes += entry.bytes;
    if (part.is_zero_page())
        count_zero(census, entry.key, part.zero());
    else
        count_diamonds(census, entry.key, part);
}

// Even levels: the squares nested in the page's. Odd levels: the sides of those squares; the w of them that
// make up one side of the page all have the same owner, since ids grow with both coordinates and with the
// face.
std::uint64_t nested_diamonds(PageKey key, int level) {
    const DiamondId square = *page_square(key);
    const int down = level - square.level();
    const std::uint64_t w = std::uint64_t{1} << (down / 2);
    if (down % 2 == 0) return w * w;
    std::uint64_t own_sides = 0;
    for (int slot = first_slot(1); slot < first_slot(2); ++slot)
        own_sides += page_slot(slot_diamond(square, slot)).key == key ? 1 : 0;
    return 2 * w * (w - 1) + w * own_sides;
}

bool visit_zero_diamonds(PageKey key, int end_level, const std::function<bool(DiamondId)>& visit) {
    const DiamondId square = *page_square(key);
    const int levels = std::min(kBandLevels, end_level - square.level());
    for (int slot = 0; slot < first_slot(levels); ++slot) {
        const DiamondId d = slot_diamond(square, slot);
        if (page_slot(d).key == key && !visit(d)) return false;
    }
    if (end_level <= square.level() + kBandLevels) return true;
    const int level = square.level() + kBandLevels;
    const std::int64_t h = half_size(level);
    const LatticeVector u = axis_vector(face_u_axis(square.face()), h),
                        v = axis_vector(face_v_axis(square.face()), h);
    for (std::int64_t y = -7; y <= 7; y += 2)
        for (std::int64_t x = -7; x <= 7; x += 2)
            if (!visit_zero_diamonds(
                    page_key(DiamondId::of_centre(narrow(wide(square.centre()) + x * u + y * v))), end_level,
                    visit))
                return false;
    return true;
}

FileCensus take_census(const std::filesystem::path& file) { return take_census(*open_file(file)); }

FileCensus take_census(const ByteSource& source) {
    const FileStructure structure(source);
    FileCensus census = structure.empty_census();
    for (const PartEntry& e : structure.parts()) count(census, e, structure.part(e));
    return census;
}

}  // namespace carat
