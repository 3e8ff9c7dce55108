#include "carat/codec/repository.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <list>
#include <mutex>
#include <optional>
#include <unordered_map>

#include "carat/codec/byte_source.hpp"
#include "directory.hpp"
#include "file_header.hpp"
#include "page.hpp"
#include "roots.hpp"

namespace carat {
namespace {

constexpr std::size_t kPageCacheBytes = 64u << 20;

class FileRepository final : public Repository {
  public:
    explicit FileRepository(std::unique_ptr<ByteSource> source) : source_(std::move(source)) {
        std::vector<std::byte> head(16);
        source_->read(0, head);
        const std::uint32_t length = parse_header_length(head, source_->name());
        if (length > source_->size())
            throw Error(ErrorCode::truncated, source_->name() + ": header ends early");
        head.resize(length);
        source_->read(0, head);
        header_ = parse_header(head, source_->name(), source_->size());
        body_.emplace(header_.info.ellipsoid());
        grid_.emplace(header_.grid());
        const std::vector<std::byte> bytes = read(header_.roots, "root values");
        roots_ = decode_roots(bytes, header_.info.n(), header_.radii[0], source_->name());
        directory_.emplace(*source_, read(header_.directory, "directory"));
        bytes_read_ = length + header_.roots.bytes + header_.directory.bytes;
    }

    const RepositoryHeader& header() const override { return header_.info; }
    std::uint64_t file_bytes() const override { return header_.file_bytes; }
    ReadCounters counters() const override {
        return {pages_read_, bytes_read_ + directory_->bytes_read(), decoded_, zero_};
    }

    bool refined(DiamondId d) const override {
        return d.level() < header_.info.deepest_level && find(d).refined();
    }

    HalfSummary summary(const Half& half) const override {
        if (half.diamond.level() < header_.info.deepest_level) {
            const Entry e = find(half.diamond);
            if (e.refined()) return e.summary(half, header_.info.quantum);
        }
        return leaf_summary(half);
    }

    Heights root(int face) const override {
        return {header_.info.n(), roots_[static_cast<std::size_t>(face)], {true, true}};
    }

    void refine(DiamondId d, const Heights& p, RefinedHeights& out) const override {
        const Entry e = find(d);
        if (!e.refined())
            throw Error(ErrorCode::usage, source_->name() + ": diamond " + to_string(d) + " is a leaf");
        thread_local CodecScratch scratch;
        const auto level = static_cast<std::size_t>(d.level());
        const BlobInfo info = e.diamond != nullptr ? e.diamond->info : BlobInfo{};
        const std::span<const std::byte> blob =
            e.diamond != nullptr ? e.diamond->blob : std::span<const std::byte>{};
        try {
            decode_residuals(header_.coding, info, blob, p.values, header_.info.n(), header_.radii[level + 1],
                             out, scratch);
        } catch (const Error& error) {
            throw Error(error.code(), source_->name() + ": diamond " + to_string(d) + ": " + error.what());
        }
        (blob.empty() ? zero_ : decoded_).fetch_add(1, std::memory_order_relaxed);
    }

  private:
    // Where a diamond was found: in a page, or under a zero page.
    struct Entry {
        std::shared_ptr<const PagePart> part;
        const PageDiamond* diamond = nullptr;
        int zero_level = -1;  // level within the zero page's span

        bool refined() const { return diamond != nullptr || zero_level >= 0; }
        HalfSummary summary(const Half& half, double quantum) const {
            SummaryValues s;
            if (diamond != nullptr)
                s = diamond->summary[static_cast<std::size_t>(half.side)];
            else
                s = {part->zero().min, part->zero().max,
                     part->zero().delta[static_cast<std::size_t>(zero_level)]};
            return {quantum * s.min, quantum * s.max, s.delta};
        }
    };

    std::vector<std::byte> read(const Extent& e, const char* what) const {
        std::vector<std::byte> bytes(e.bytes);
        source_->read(e.offset, bytes);
        if (checksum_of(bytes) != e.checksum)
            throw Error(ErrorCode::corrupt, source_->name() + ": " + what + " fails its checksum");
        return bytes;
    }

    Entry find(DiamondId d) const {
        const PageSlot at = page_slot(d);
        int slot = at.slot;
        for (std::optional<PageKey> key = at.key; key; key = parent_page(*key), slot = 0) {
            Entry e;
            e.part = part(*key, slot);
            if (!e.part) continue;
            if (e.part->is_zero_page()) {
                const ZeroSpan& z = e.part->zero();
                const int level = d.level();
                if (level < z.end_level)
                    e.zero_level = level - (z.end_level - static_cast<int>(z.delta.size()));
            } else if (*key == at.key) {
                e.diamond = e.part->find(at.slot);
            }
            return e;
        }
        return {};
    }

    // The part of a page that holds a slot, from the cache or the file; null if the file has no such page.
    std::shared_ptr<const PagePart> part(PageKey key, int slot) const {
        {
            const std::lock_guard lock(mutex_);
            if (const auto it = cache_.find(key); it != cache_.end())
                for (Cached& c : it->second)
                    if (slot >= c.first_slot && slot < c.end_slot) {
                        lru_.splice(lru_.begin(), lru_, c.use);
                        return c.part;
                    }
        }
        const std::optional<PartEntry> entry = directory_->find(key, slot);
        std::shared_ptr<const PagePart> loaded;
        int first = 0, end = kPageSlots;
        if (entry) {
            std::vector<std::byte> bytes(entry->bytes);
            source_->read(entry->offset, bytes);
            loaded =
                std::make_shared<PagePart>(std::move(bytes), key, entry->first_slot, source_->name(), *grid_);
            check_depth(*loaded, key);
            first = loaded->first_slot();
            end = loaded->end_slot();
            if (slot >= end)
                throw Error(ErrorCode::corrupt,
                            source_->name() + ": " + page_name(key) + " lacks slot " + std::to_string(slot));
            pages_read_.fetch_add(1, std::memory_order_relaxed);
            bytes_read_.fetch_add(entry->bytes, std::memory_order_relaxed);
        }
        remember(key, first, end, loaded);
        return loaded;
    }

    // No diamond may be refined at or below the header's deepest level.
    void check_depth(const PagePart& loaded, PageKey key) const {
        const int levels = header_.info.deepest_level - page_square(key)->level();
        const int end_slot = levels <= 0 ? 0 : first_slot(std::min(levels, kBandLevels));
        const bool too_deep = loaded.is_zero_page()
                                  ? loaded.zero().end_level > header_.info.deepest_level
                                  : !loaded.diamonds().empty() && loaded.diamonds().back().slot >= end_slot;
        if (too_deep)
            throw Error(ErrorCode::corrupt,
                        source_->name() + ": " + page_name(key) + " refines beyond the file's depth");
    }

    void remember(PageKey key, int first, int end, std::shared_ptr<const PagePart> loaded) const {
        const std::lock_guard lock(mutex_);
        for (const Cached& c : cache_[key])
            if (c.first_slot == first) return;  // another thread was faster
        lru_.push_front({key, first});
        cached_bytes_ += cost(loaded);
        cache_[key].push_back({first, end, std::move(loaded), lru_.begin()});
        while (cached_bytes_ > kPageCacheBytes && lru_.size() > 1) {
            const auto [old_key, old_first] = lru_.back();
            auto& parts = cache_[old_key];
            const int old = old_first;
            const auto it = std::find_if(parts.begin(), parts.end(),
                                         [old](const Cached& c) { return c.first_slot == old; });
            cached_bytes_ -= cost(it->part);
            parts.erase(it);
            if (parts.empty()) cache_.erase(old_key);
            lru_.pop_back();
        }
    }
    static std::size_t cost(const std::shared_ptr<const PagePart>& p) {
        constexpr std::size_t kIndexBytes = 8192;  // the parsed index and the cache's own nodes
        return kIndexBytes + (p ? p->bytes() : 0);
    }

    HalfSummary leaf_summary(const Half& half) const {
        const double q = header_.info.quantum;
        HalfSummary s{q * header_.info.min_height, q * header_.info.max_height, 0};
        if (const std::optional<Half> up = parent_half(half)) {
            const Entry e = find(up->diamond);
            if (!e.refined())
                throw Error(ErrorCode::usage, source_->name() + ": half of diamond " +
                                                  to_string(half.diamond) + " is not in the file");
            s = e.summary(*up, q);
        }
        const double highest = std::max(std::abs(s.min_height), std::abs(s.max_height));
        s.delta = curvature_bound(*body_, half, header_.info.cells())
                      .of_heights(highest, s.max_height - s.min_height);
        return s;
    }
    struct Cached {
        int first_slot, end_slot;
        std::shared_ptr<const PagePart> part;
        std::list<std::pair<PageKey, int>>::iterator use;
    };

    std::unique_ptr<ByteSource> source_;
    FileHeader header_;
    RootHeights roots_;
    std::optional<Directory> directory_;
    std::optional<Ellipsoid> body_;
    std::optional<SummaryGrid> grid_;

    mutable std::mutex mutex_;
    mutable std::unordered_map<PageKey, std::vector<Cached>> cache_;
    mutable std::list<std::pair<PageKey, int>> lru_;
    mutable std::size_t cached_bytes_ = 0;
    mutable std::atomic<std::uint64_t> pages_read_{0}, bytes_read_{0}, decoded_{0}, zero_{0};
};

}  // namespace

std::shared_ptr<const Repository> Repository::open(const std::filesystem::path& file) {
    return open(open_file(file));
}

std::shared_ptr<const Repository> Repository::open(std::unique_ptr<ByteSource> source) {
    return std::make_shared<FileRepository>(std::move(source));
}

}  // namespace carat
