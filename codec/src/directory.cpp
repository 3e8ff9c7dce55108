#include "directory.hpp"

#include <algorithm>

#include "page.hpp"

namespace carat {
namespace {

std::pair<PageKey, int> position(const PartEntry& e) { return {e.key, e.first_slot}; }
std::pair<PageKey, int> position(const BlockEntry& e) { return {e.first_key, e.first_slot}; }

}  // namespace

Directory::Directory(const ByteSource& source, std::span<const std::byte> top) : source_(source) {
    ByteParser in(top, source.name() + ": directory");
    if (top.size() % kBlockEntryBytes != 0) in.fail("has a length no writer makes");
    while (in.left() > 0) {
        const BlockEntry e = get_block_entry(in);
        if (e.entries == 0 || e.entries > kDirectoryBlockEntries) in.fail("has a block of impossible size");
        if (!blocks_.empty() && position(blocks_.back()) >= position(e)) in.fail("is out of order");
        blocks_.push_back(e);
    }
}

std::optional<PartEntry> Directory::find(PageKey key, int slot) const {
    const std::pair<PageKey, int> wanted{key, slot};
    auto it = std::upper_bound(blocks_.begin(), blocks_.end(), wanted,
                               [](const auto& w, const BlockEntry& e) { return w < position(e); });
    // A page may not begin in the middle: were its first part missing, its diamonds would be lost in silence.
    const auto missing = [&]() -> std::optional<PartEntry> {
        if (it != blocks_.end() && it->first_key == key)
            throw Error(ErrorCode::corrupt,
                        source_.name() + ": " + page_name(key) + " lacks slot " + std::to_string(slot));
        return std::nullopt;
    };
    if (it == blocks_.begin()) return missing();
    const auto entries = block(static_cast<std::size_t>(it - blocks_.begin()) - 1);
    const auto after = std::upper_bound(entries->begin(), entries->end(), wanted,
                                        [](const auto& w, const PartEntry& e) { return w < position(e); });
    if (after == entries->begin() || (after - 1)->key != key) return missing();
    return *(after - 1);
}

std::vector<PartEntry> Directory::all() const {
    std::vector<PartEntry> out;
    for (std::size_t k = 0; k < blocks_.size(); ++k) {
        const auto entries = block(k);
        out.insert(out.end(), entries->begin(), entries->end());
    }
    return out;
}

std::shared_ptr<const Directory::Block> Directory::block(std::size_t index) const {
    {
        const std::lock_guard lock(mutex_);
        if (const auto it = loaded_.find(index); it != loaded_.end()) return it->second;
    }
    auto loaded = std::make_shared<const Block>(load(index));
    const std::lock_guard lock(mutex_);
    return loaded_.emplace(index, std::move(loaded)).first->second;
}

Directory::Block Directory::load(std::size_t index) const {
    const BlockEntry& b = blocks_[index];
    const std::string what = source_.name() + ": directory block " + std::to_string(index);
    std::vector<std::byte> bytes(b.entries * kPartEntryBytes);
    source_.read(b.offset, bytes);
    bytes_read_.fetch_add(bytes.size(), std::memory_order_relaxed);
    if (checksum_of(bytes) != b.checksum) throw Error(ErrorCode::corrupt, what + " fails its checksum");
    ByteParser in(bytes, what);
    Block out;
    for (std::uint32_t k = 0; k < b.entries; ++k) {
        const PartEntry e = get_part_entry(in);
        if (!out.empty() && position(out.back()) >= position(e)) in.fail("is out of order");
        if (e.offset > source_.size() || e.bytes > source_.size() - e.offset)
            in.fail("has an entry outside the file");
        if (e.bytes > kMaxSinglePartBytes) in.fail("has a part above 1 MiB");
        const bool first_of_page = out.empty() ? index == 0 : out.back().key != e.key;
        if (e.first_slot >= kPageSlots || (first_of_page && e.first_slot != 0))
            in.fail("has a page without its first slots");
        out.push_back(e);
    }
    if (position(out.front()) != position(b)) in.fail("does not begin where the directory says");
    return out;
}

}  // namespace carat
