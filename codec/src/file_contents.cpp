#include "carat/codec/file_contents.hpp"

#include <algorithm>
#include <numeric>
#include <unordered_map>

#include "carat/globe/error.hpp"
#include "census.hpp"

namespace carat {
namespace {

// A diamond and where its blob lies.
struct Placed {
    DiamondEntry entry;
    std::uint64_t offset = 0;
    std::int32_t zero_page = -1;
};

}  // namespace

struct FileContents::State {
    explicit State(const std::filesystem::path& file) : source(open_file(file)), structure(*source) {
        for (const PartEntry& e : structure.parts()) {
            const PagePart part = structure.part(e);
            if (part.is_zero_page())
                add_zero_page(e, part.zero());
            else
                add_diamonds(e, part);
        }
        sort();
    }

    void add(const Placed& d) {
        if (placed.size() >= structure.header().info.refined_diamonds)
            throw Error(ErrorCode::corrupt, source->name() + ": holds more diamonds than its header says");
        placed.push_back(d);
    }
    void add_diamonds(const PartEntry& e, const PagePart& part) {
        diamonds_of[e.key] += part.diamonds().size();
        const DiamondId square = *page_square(e.key);
        std::uint64_t end = e.offset + e.bytes;  // the part ends with its last blob
        for (auto d = part.diamonds().rbegin(); d != part.diamonds().rend(); ++d) {
            end -= d->blob.size();
            add({{slot_diamond(square, d->slot), d->info, d->blob.size(), d->summary}, end, -1});
        }
    }
    void add_zero_page(const PartEntry& e, const ZeroSpan& zero) {
        const int top = page_square(e.key)->level();
        visit_zero_diamonds(e.key, zero.end_level, [&](DiamondId d) {
            const SummaryValues s{zero.min, zero.max, zero.delta[static_cast<std::size_t>(d.level() - top)]};
            add({{d, {}, 0, {s, s}}, 0, zero_pages});
            return true;  // add() ends it
        });
        ++zero_pages;
    }
    void sort() {
        std::vector<int> levels(placed.size());
        std::vector<std::size_t> order(placed.size());
        std::iota(order.begin(), order.end(), std::size_t{0});
        for (std::size_t k = 0; k < placed.size(); ++k) levels[k] = placed[k].entry.id.level();
        std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
            return std::pair(levels[a], placed[a].entry.id) < std::pair(levels[b], placed[b].entry.id);
        });
        for (const std::size_t k : order) {
            diamonds.push_back(placed[k].entry);
            offsets.push_back(placed[k].offset);
            marks.push_back(placed[k].zero_page);
        }
        placed = {};
    }

    std::unique_ptr<ByteSource> source;
    FileStructure structure;
    std::vector<Placed> placed;  // while the pages are read
    std::vector<DiamondEntry> diamonds;
    std::vector<std::uint64_t> offsets;
    std::vector<std::int32_t> marks;
    std::int32_t zero_pages = 0;
    std::unordered_map<PageKey, std::size_t> diamonds_of;  // pages but zero pages
};

FileContents::FileContents(const std::filesystem::path& file) : state_(std::make_unique<State>(file)) {}
FileContents::~FileContents() = default;

const RepositoryHeader& FileContents::header() const { return state_->structure.header().info; }
const Coding& FileContents::coding() const { return state_->structure.header().coding; }
const std::vector<DiamondEntry>& FileContents::diamonds() const { return state_->diamonds; }
std::int32_t FileContents::zero_page(std::size_t index) const { return state_->marks[index]; }
std::size_t FileContents::zero_pages() const { return static_cast<std::size_t>(state_->zero_pages); }

void FileContents::blob(std::size_t index, std::vector<std::byte>& out) const {
    out.resize(state_->diamonds[index].blob_bytes);
    if (!out.empty()) state_->source->read(state_->offsets[index], out);
}

bool FileContents::copy(std::uint64_t key, std::size_t diamonds,
                        const std::function<void(int, std::span<const std::byte>)>& add) const {
    const auto page = state_->diamonds_of.find(key);
    if (page == state_->diamonds_of.end() || page->second != diamonds) return false;
    const std::vector<PartEntry>& parts = state_->structure.parts();
    auto part = std::lower_bound(parts.begin(), parts.end(), key,
                                 [](const PartEntry& e, PageKey k) { return e.key < k; });
    std::vector<std::byte> bytes;
    for (; part != parts.end() && part->key == key; ++part) {
        bytes.resize(part->bytes);
        state_->source->read(part->offset, bytes);
        add(part->first_slot, bytes);
    }
    return true;
}

}  // namespace carat
