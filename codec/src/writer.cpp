#include "carat/codec/writer.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <map>
#include <optional>
#include <system_error>
#include <unordered_map>
#include <unordered_set>

#include "file_header.hpp"
#include "page.hpp"

namespace carat {
namespace {

// A diamond of a page.
struct PageEntry {
    int slot = 0;
    std::uint32_t index = 0;  // of the entry that the writer was given
    const DiamondEntry* entry = nullptr;
};

// The diamonds of one page, in slot order.
struct PageContents {
    PageKey key;
    std::vector<PageEntry> diamonds;
};

bool is_plain_zero(const PageEntry& d) { return d.entry->blob_bytes == 0 && d.entry->info == BlobInfo{}; }

int level_in_page(int slot) {
    int j = 0;
    while (slot >= first_slot(j + 1)) ++j;
    return j;
}

// Number of slots of sub-level j that are the page's own.
int own_slots(PageKey key, DiamondId square, int j) {
    int own = 0;
    for (int slot = first_slot(j); slot < first_slot(j + 1); ++slot)
        own += page_slot(slot_diamond(square, slot)).key == key ? 1 : 0;
    return own;
}

std::string megabytes(std::uint64_t bytes) {
    return std::to_string((bytes + (std::uint64_t{1} << 20) - 1) >> 20) + " MiB";
}

// Throws Error(usage) for a header that readers refuse.
void check_readable(std::span<const std::byte> header, const std::string& file, std::uint64_t file_bytes) {
    try {
        parse_header_length(header.first(16), file);
        parse_header(header, file, file_bytes);
    } catch (const Error& e) {
        throw Error(ErrorCode::usage, std::string("unfit for a repository: ") + e.what());
    }
}

// Throws Error(usage) if a diamond comes twice.
void sort_slots(std::vector<PageEntry>& diamonds, PageKey key) {
    std::sort(diamonds.begin(), diamonds.end(),
              [](const PageEntry& a, const PageEntry& b) { return a.slot < b.slot; });
    const auto twice = std::adjacent_find(diamonds.begin(), diamonds.end(),
                                          [](const auto& a, const auto& b) { return a.slot == b.slot; });
    if (twice != diamonds.end()) throw Error(ErrorCode::usage, page_name(key) + " is given a diamond twice");
}

// The 64 pages nested in a page.
std::vector<PageKey> nested_pages(DiamondId square) {
    std::vector<PageKey> out;
    const int level = square.level() + kBandLevels;
    if (level > kDeepestId) return out;
    const int first = first_slot(4);  // the 16 squares of sub-level 4; each holds 4 of sub-level 6
    for (int k = 0; k < 16; ++k) {
        const LatticePoint c = slot_diamond(square, first + k).centre();
        const std::int64_t h = half_size(level);
        const LatticeVector u = axis_vector(face_u_axis(square.face()), h),
                            v = axis_vector(face_v_axis(square.face()), h);
        for (const int su : {-1, 1})
            for (const int sv : {-1, 1})
                out.push_back(page_key(DiamondId::of_centre(narrow(wide(c) + su * u + sv * v))));
    }
    return out;
}

// A page that one zero mark can replace. Beyond its end level lie loosest_end - end_level levels of which the
// page owns no diamond (its neighbours own all four of its sides), so that the mark may just as well cover
// them.
struct ZeroMark {
    ZeroSpan span;
    int loosest_end = 0;

    bool can_end_at(int level) const { return span.end_level <= level && level <= loosest_end; }
};

// Finds pages that a single "zero to level D" mark replaces, deepest band first.
class ZeroMarks {
  public:
    ZeroMarks(const std::map<PageKey, PageContents>& pages, const SummaryGrid& grid)
        : pages_(pages), grid_(grid) {
        for (auto it = pages.rbegin(); it != pages.rend(); ++it)  // keys ascend with the band
            if (auto mark = mark_of(it->second)) marks_[it->first] = std::move(*mark);
        for (const auto& [key, mark] : marks_) absorb(key, mark.span);
    }
    const ZeroSpan* find(PageKey key) const {
        const auto it = marks_.find(key);
        return it == marks_.end() ? nullptr : &it->second.span;
    }
    bool absorbed(PageKey key) const { return absorbed_.contains(key); }

  private:
    std::optional<ZeroMark> mark_of(const PageContents& page) const {
        if (!std::all_of(page.diamonds.begin(), page.diamonds.end(), is_plain_zero)) return std::nullopt;
        const DiamondId square = *page_square(page.key);
        const std::optional<int> full = full_levels(page, square);
        if (!full) return std::nullopt;
        ZeroMark mark{own_span(page, square.level(), *full), square.level() + *full};
        if (*full < kBandLevels && own_slots(page.key, square, *full) == 0) ++mark.loosest_end;
        if (!merge_nested(square, mark)) return std::nullopt;
        return mark;
    }
    // Number of sub-levels that are refined completely, if the others are not refined at all.
    static std::optional<int> full_levels(const PageContents& page, DiamondId square) {
        std::array<int, kBandLevels> count{};
        for (const PageEntry& d : page.diamonds) ++count[static_cast<std::size_t>(level_in_page(d.slot))];
        const int full = level_in_page(page.diamonds.back().slot) + 1;
        for (int j = 0; j < full; ++j)
            if (count[static_cast<std::size_t>(j)] != own_slots(page.key, square, j)) return std::nullopt;
        return full;
    }
    ZeroSpan own_span(const PageContents& page, int level, int full) const {
        ZeroSpan span;
        span.end_level = level + full;
        span.delta.resize(static_cast<std::size_t>(full));
        for (const PageEntry& d : page.diamonds) {
            const int j = level_in_page(d.slot);
            double& delta = span.delta[static_cast<std::size_t>(j)];
            for (const SummaryValues& exact : d.entry->summary) {
                const SummaryValues s = grid_.rounded(exact, level + j);
                span.min = std::min(span.min, s.min);
                span.max = std::max(span.max, s.max);
                delta = std::max(delta, s.delta);
            }
        }
        return span;
    }
    // Extends the mark over nested pages: all of them zero to the same level, or none refined.
    bool merge_nested(DiamondId square, ZeroMark& mark) const {
        std::vector<const ZeroMark*> nested;
        std::size_t present = 0;
        const std::vector<PageKey> keys = nested_pages(square);
        for (const PageKey key : keys) {
            present += pages_.contains(key) ? 1 : 0;
            if (const auto it = marks_.find(key); it != marks_.end()) nested.push_back(&it->second);
        }
        if (present == 0) return true;
        if (nested.size() != keys.size() || !mark.can_end_at(square.level() + kBandLevels)) return false;
        int end = 0;
        for (const ZeroMark* z : nested) end = std::max(end, z->span.end_level);
        const auto fits = [end](const ZeroMark* z) { return z->can_end_at(end); };
        if (!std::all_of(nested.begin(), nested.end(), fits)) return false;
        mark.span.end_level = end;
        mark.loosest_end = INT32_MAX;
        mark.span.delta.resize(static_cast<std::size_t>(end - square.level()));
        for (const ZeroMark* z : nested) include(mark, *z);
        return true;
    }
    static void include(ZeroMark& mark, const ZeroMark& nested) {
        ZeroSpan& span = mark.span;
        const ZeroSpan& z = nested.span;
        mark.loosest_end = std::min(mark.loosest_end, nested.loosest_end);
        span.min = std::min(span.min, z.min);
        span.max = std::max(span.max, z.max);
        for (std::size_t k = 0; k < z.delta.size(); ++k) {
            double& delta = span.delta[static_cast<std::size_t>(kBandLevels) + k];
            delta = std::max(delta, z.delta[k]);
        }
    }
    void absorb(PageKey key, const ZeroSpan& span) {
        const DiamondId square = *page_square(key);
        if (span.end_level <= square.level() + kBandLevels) return;
        for (const PageKey nested : nested_pages(square)) absorbed_.insert(nested);
    }

    const std::map<PageKey, PageContents>& pages_;
    const SummaryGrid& grid_;
    std::unordered_map<PageKey, ZeroMark> marks_;
    std::unordered_set<PageKey> absorbed_;
};

}  // namespace

struct RepositoryWriter::State {
    std::filesystem::path path, partial;
    std::ofstream file;
    FileHeader header;
    std::vector<PartEntry> parts;
    std::uint64_t expected_bytes = 0;  // of the file, about
    bool completed = false, finished = false;

    std::uint64_t position() { return static_cast<std::uint64_t>(file.tellp()); }
    void append(std::span<const std::byte> bytes) {
        file.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        check();
    }
    void check() {
        if (!file) fail(errno);
    }
    [[noreturn]] void fail(int error) const {
        if (error != ENOSPC && error != EDQUOT)
            throw Error(ErrorCode::io, partial.string() + ": cannot write: " + std::strerror(error));
        std::error_code ignored;
        const std::filesystem::space_info space =
            std::filesystem::space(std::filesystem::absolute(partial).parent_path(), ignored);
        throw Error(ErrorCode::io, partial.string() + ": no space left: the file needs about " +
                                       megabytes(expected_bytes) + ", " +
                                       megabytes(ignored ? 0 : space.available) + " are free");
    }
    void remove_partial() {
        file.close();
        std::error_code ignored;
        std::filesystem::remove(partial, ignored);
    }
    void add_part(PageKey key, int first, std::span<const std::byte> bytes) {
        parts.push_back(
            {key, position(), static_cast<std::uint32_t>(bytes.size()), static_cast<std::uint16_t>(first)});
        append(bytes);
    }
    void write_page(const PageContents& page, const BlobSource& blobs);
    bool copy_page(const PageContents& page, const OldPages& old);
    Extent write_directory();
    void write_header();
};

// Splits a page greedily: a part takes slots while it stays within kMaxPartBytes, and at least one diamond.
void RepositoryWriter::State::write_page(const PageContents& page, const BlobSource& source) {
    const SummaryGrid grid = header.grid();
    std::vector<std::vector<std::byte>> blobs(page.diamonds.size());
    std::vector<PageDiamond> all;
    for (std::size_t k = 0; k < blobs.size(); ++k) {
        const PageEntry& d = page.diamonds[k];
        if (d.entry->blob_bytes > 0) source(d.index, blobs[k]);
        if (blobs[k].size() != d.entry->blob_bytes)
            throw Error(ErrorCode::usage,
                        page_name(page.key) + " is given a blob of another length than announced");
        const int level = d.entry->id.level();
        all.push_back({d.slot,
                       d.entry->info,
                       blobs[k],
                       {grid.rounded(d.entry->summary[0], level), grid.rounded(d.entry->summary[1], level)}});
    }
    const SummaryRange range = range_of(all);
    std::size_t begin = 0;
    int first = 0;
    while (begin < all.size()) {
        std::size_t cost = kPartHeaderBytes + (kPageSlots + 7) / 8, end = begin;
        for (; end < all.size(); ++end) {
            const std::size_t more = part_cost(page.key, all[end], range, grid);
            if (end > begin && cost + more > kMaxPartBytes) break;
            cost += more;
        }
        const int last = end < all.size() ? all[end].slot : kPageSlots;
        add_part(page.key, first,
                 encode_part(page.key, first, last - first, std::span(all).subspan(begin, end - begin), range,
                             grid));
        first = last;
        begin = end;
    }
}

// The same diamonds make the same bytes.
bool RepositoryWriter::State::copy_page(const PageContents& page, const OldPages& old) {
    if (old.stock == nullptr) return false;
    for (const PageEntry& d : page.diamonds)
        if (!old.unchanged(d.index)) return false;
    return old.stock->copy(page.key, page.diamonds.size(), [&](int first, std::span<const std::byte> bytes) {
        add_part(page.key, first, bytes);
    });
}

Extent RepositoryWriter::State::write_directory() {
    std::vector<std::byte> top;
    for (std::size_t begin = 0; begin < parts.size(); begin += kDirectoryBlockEntries) {
        const std::size_t end = std::min(parts.size(), begin + kDirectoryBlockEntries);
        std::vector<std::byte> block;
        for (std::size_t k = begin; k < end; ++k) put(block, parts[k]);
        put(top, BlockEntry{parts[begin].key, parts[begin].first_slot,
                            static_cast<std::uint32_t>(end - begin), position(), checksum_of(block)});
        append(block);
    }
    const Extent extent{position(), static_cast<std::uint32_t>(top.size()), checksum_of(top)};
    append(top);
    return extent;
}

RepositoryWriter::RepositoryWriter(std::filesystem::path path, WriterSetup setup, const EncodedRoots& roots)
    : state_(std::make_unique<State>()) {
    State& s = *state_;
    s.path = std::move(path);
    s.partial = s.path.string() + ".partial";
    s.file.open(s.partial, std::ios::binary | std::ios::trunc);
    if (!s.file) throw Error(ErrorCode::io, s.partial.string() + ": cannot create: " + std::strerror(errno));
    s.header.info.log2_cells = setup.log2_cells;
    s.header.info.quantum = setup.quantum;
    s.header.info.tolerance = setup.tolerance;
    s.header.info.body_a = setup.body.a();
    s.header.info.body_b = setup.body.b();
    s.header.info.body = setup.body.name();
    s.header.info.vertical_datum = std::move(setup.vertical_datum);
    s.header.info.provenance = std::move(setup.provenance);
    s.header.info.rms_tolerance = setup.rms_tolerance;
    s.header.radii = std::move(setup.radii);
    s.header.coding = setup.coding;
    if (setup.coding.coder == CoderId::range && setup.coding.tables != RangeTables::built_in())
        s.header.tables = setup.coding.tables->bytes();
    s.header.info.min_height = INT32_MAX;
    s.header.info.max_height = INT32_MIN;
    for (const auto& face : roots.heights)
        for (const std::int32_t h : face) {
            s.header.info.min_height = std::min(s.header.info.min_height, h);
            s.header.info.max_height = std::max(s.header.info.max_height, h);
        }
    s.expected_bytes = setup.expected_bytes;
    try {
        s.append(s.header.to_bytes());  // holds the place; every length is known
        s.header.roots = {s.position(), static_cast<std::uint32_t>(roots.bytes.size()),
                          checksum_of(roots.bytes)};
        s.append(roots.bytes);
    } catch (...) {
        s.remove_partial();
        throw;
    }
}

RepositoryWriter::~RepositoryWriter() {
    if (!state_->finished) state_->remove_partial();
}

void RepositoryWriter::write(std::vector<DiamondRecord> diamonds) {
    std::vector<DiamondEntry> entries;
    for (const DiamondRecord& d : diamonds)
        entries.push_back({d.id, d.residuals.info, d.residuals.blob.size(), d.summary});
    write(entries,
          [&](std::size_t k, std::vector<std::byte>& out) { out = std::move(diamonds[k].residuals.blob); });
}

void RepositoryWriter::write(std::span<const DiamondEntry> diamonds, const BlobSource& blobs,
                             const OldPages& old) {
    if (diamonds.size() > UINT32_MAX) throw Error(ErrorCode::limit, "more than 2^32 refined diamonds");
    State& s = *state_;
    std::map<PageKey, PageContents> pages;
    for (std::size_t k = 0; k < diamonds.size(); ++k) {
        const DiamondEntry& d = diamonds[k];
        const PageSlot at = page_slot(d.id);
        PageContents& page = pages[at.key];
        page.key = at.key;
        page.diamonds.push_back({at.slot, static_cast<std::uint32_t>(k), &d});
        s.header.info.deepest_level = std::max(s.header.info.deepest_level, d.id.level() + 1);
        for (const SummaryValues& half : d.summary) {
            s.header.info.min_height = std::min(s.header.info.min_height, half.min);
            s.header.info.max_height = std::max(s.header.info.max_height, half.max);
        }
    }
    s.header.info.refined_diamonds = diamonds.size();
    for (auto& [key, page] : pages) sort_slots(page.diamonds, key);
    const SummaryGrid grid = s.header.grid();
    const ZeroMarks zero(pages, grid);
    for (const auto& [key, page] : pages) {
        if (zero.absorbed(key)) continue;
        if (const ZeroSpan* span = zero.find(key))
            s.add_part(key, 0, encode_zero_page(key, *span));
        else if (!s.copy_page(page, old))
            s.write_page(page, blobs);
    }
}

void RepositoryWriter::State::write_header() {
    const std::vector<std::byte> bytes = header.to_bytes();
    check_readable(bytes, path.string(), header.file_bytes);
    file.seekp(0);
    append(bytes);
    file.flush();
    check();
}

const std::filesystem::path& RepositoryWriter::complete() {
    State& s = *state_;
    if (s.completed) return s.partial;
    s.header.directory = s.write_directory();
    s.header.file_bytes = s.position();
    s.write_header();
    s.completed = true;
    return s.partial;
}

void RepositoryWriter::replace_provenance(std::string provenance) {
    State& s = *state_;
    std::string& old = s.header.info.provenance;
    if (provenance.size() > old.size())
        throw Error(ErrorCode::usage, s.path.string() + ": the new provenance is longer than the old");
    provenance.resize(old.size(), ' ');
    old = std::move(provenance);
    s.write_header();
}

std::uint64_t RepositoryWriter::finish() {
    State& s = *state_;
    complete();
    s.file.close();
    s.check();
    std::error_code failed;
    std::filesystem::rename(s.partial, s.path, failed);
    if (failed)
        throw Error(ErrorCode::io, s.path.string() + ": cannot rename into place: " + failed.message());
    s.finished = true;
    return s.header.file_bytes;
}

}  // namespace carat
