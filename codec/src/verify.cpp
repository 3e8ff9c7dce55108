#include "carat/codec/verify.hpp"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <exception>
#include <mutex>
#include <thread>
#include <unordered_map>
#include <unordered_set>

#include "carat/codec/heights.hpp"
#include "carat/codec/surface.hpp"
#include "census.hpp"

namespace carat {
namespace {

// What the threads find, told once each.
class Findings {
  public:
    explicit Findings(std::size_t limit) : limit_(limit) {}

    void add(const std::string& what) {
        constexpr std::size_t kRemembered = 1u << 16;  // distinct damages; beyond, repetitions count too
        const std::lock_guard lock(mutex_);
        if (seen_.contains(what)) return;
        if (seen_.size() < kRemembered) seen_.insert(what);
        ++count_;
        if (list_.size() < limit_) list_.push_back(what);
    }
    void tell(VerifyReport& report) {
        report.damage = std::move(list_);
        report.damage_count = count_;
    }

  private:
    std::mutex mutex_;
    std::size_t limit_;
    std::unordered_set<std::string> seen_;
    std::vector<std::string> list_;
    std::uint64_t count_ = 0;
};

// Every page parses, lies where it should and holds what is its own. Returns the sound parts.
class PageCheck {
  public:
    PageCheck(const FileStructure& structure, Findings& findings, FileCensus& census)
        : structure_(structure), findings_(findings), census_(census) {}

    std::vector<PartEntry> run() {
        std::vector<PartEntry> sound;
        for (const PartEntry& e : structure_.parts()) try {
                const PagePart part = structure_.part(e);
                count(census_, e, part);
                check_slots(e, part);
                check_owners(e, part);
                if (part.is_zero_page()) zero_pages_.insert(e.key);
                sound.push_back(e);
            } catch (const Error& error) {
                findings_.add(error.what());
            }
        check_end(kNoKey);
        for (const PartEntry& e : structure_.parts()) check_nesting(e.key);
        return sound;
    }

  private:
    static constexpr PageKey kNoKey = ~PageKey{0};

    // The parts of a page follow each other from slot 0 to the last.
    void check_slots(const PartEntry& e, const PagePart& part) {
        if (e.key != key_) {
            check_end(e.key);
            next_slot_ = 0;
        }
        if (part.first_slot() != next_slot_)
            findings_.add(page_name(e.key) + " lacks its slots from " + std::to_string(next_slot_));
        next_slot_ = part.end_slot();
    }
    void check_end(PageKey next) {
        if (key_ != kNoKey && next_slot_ != kPageSlots)
            findings_.add(page_name(key_) + " lacks its slots from " + std::to_string(next_slot_));
        key_ = next;
    }
    void check_owners(const PartEntry& e, const PagePart& part) {
        const DiamondId square = *page_square(e.key);
        for (const PageDiamond& d : part.diamonds())
            if (const DiamondId id = slot_diamond(square, d.slot); page_slot(id).key != e.key)
                findings_.add(page_name(e.key) + " holds diamond " + to_string(id) + " of another page");
    }
    void check_nesting(PageKey key) {
        for (auto up = parent_page(key); up; up = parent_page(*up))
            if (zero_pages_.contains(*up))
                findings_.add(page_name(key) + " lies below " + page_name(*up) + ", which is all zero");
    }

    const FileStructure& structure_;
    Findings& findings_;
    FileCensus& census_;
    std::unordered_set<PageKey> zero_pages_;
    PageKey key_ = kNoKey;
    int next_slot_ = 0;
};

struct Range {
    double min, max;  // metres
};

// Checks diamonds one at a time; one for each thread.
class DiamondCheck {
  public:
    DiamondCheck(const Surface& surface, Findings& findings)
        : surface_(surface), file_(surface.repository()), findings_(findings) {
        const auto n = static_cast<std::size_t>(file_.header().n());
        for (auto& side : sides_) side.resize(n * n);
    }

    std::uint64_t decoded = 0, unreachable = 0, heights = 0, shared = 0;

    void check(DiamondId d) {
        try {
            if (!parents_refined(d)) {
                ++unreachable;
                return;
            }
            check_seam(d);
            check_heights(d);
            ++decoded;
        } catch (const Error& error) {
            findings_.add(error.what());
            ++unreachable;
        }
    }

  private:
    bool parents_refined(DiamondId d) {
        bool all = true;
        for (int side = 0; d.level() > 0 && side < 2; ++side) {
            const DiamondId up = *parent(d, side);
            if (file_.refined(up)) continue;
            findings_.add("diamond " + to_string(d) + " is refined, its parent " + to_string(up) + " is not");
            all = false;
        }
        return all;
    }

    // Both parents give the vertices of the longest edge.
    void check_seam(DiamondId d) {
        if (d.level() == 0) return;
        for (int side = 0; side < 2; ++side) {
            const DiamondId up = *parent(d, side);
            gather_half(*surface_.refined_heights(up), up, {d, side},
                        sides_[static_cast<std::size_t>(side)].data());
        }
        const auto n = static_cast<std::size_t>(file_.header().n());
        for (std::size_t k = 0; k < n; ++k)
            if (sides_[0][k * (n + 1)] != sides_[1][k * (n + 1)]) {
                findings_.add("diamond " + to_string(d) + ": its parents disagree on their common edge");
                return;
            }
        shared += n;
    }

    void check_heights(DiamondId d) {
        const auto p = surface_.heights(d);
        const auto refined = surface_.refined_heights(d);
        const int n = p->n;
        for (int side = 0; side < 2; ++side) {
            const Range range = allowed({d, side});
            bool inside = true;
            for (int i = 0; i < n; ++i) {
                const int first = side == 0 ? 0 : i, end = side == 0 ? i + 1 : n;
                inside &= within(p->values, i * n + first, i * n + end, range);
                inside &= within(refined->v, i * n + first, i * n + end, range);
                if (i < n - 1) {
                    const int row = i * (n - 1);
                    inside &= within(refined->c, row + first, row + std::min(end, n - 1), range);
                }
            }
            if (!inside)
                findings_.add("diamond " + to_string(d) + " has heights outside the summaries of half " +
                              std::to_string(side) + " or of a half that contains it");
        }
    }
    bool within(const std::vector<std::int32_t>& values, int first, int end, const Range& range) {
        heights += static_cast<std::uint64_t>(end - first);
        const double q = file_.header().quantum;
        const auto [low, high] = std::minmax_element(values.begin() + first, values.begin() + end);
        return q * *low >= range.min && q * *high <= range.max;
    }

    // What the summaries of a half and of all that contain it leave to its heights.
    Range allowed(const Half& half) {
        constexpr std::size_t kKept = 1u << 16;
        if (const auto it = allowed_.find(half); it != allowed_.end()) return it->second;
        const HalfSummary s = file_.summary(half);
        Range range{s.min_height, s.max_height};
        const std::optional<Half> up = parent_half(half);
        const double q = file_.header().quantum;
        const Range above =
            up ? allowed(*up) : Range{q * file_.header().min_height, q * file_.header().max_height};
        range.min = std::max(range.min, above.min);
        range.max = std::min(range.max, above.max);
        if (allowed_.size() >= kKept) allowed_.clear();
        allowed_[half] = range;
        return range;
    }

    const Surface& surface_;
    const Repository& file_;
    Findings& findings_;
    std::array<std::vector<std::int32_t>, 2> sides_;
    std::unordered_map<Half, Range, HalfHash> allowed_;
};

// Every diamond of the sound parts, by several threads that move through the file together.
class Decoding {
  public:
    Decoding(const FileStructure& structure, std::vector<PartEntry> parts, const VerifyOptions& options,
             Findings& findings, VerifyReport& report)
        : structure_(structure),
          parts_(std::move(parts)),
          options_(options),
          findings_(findings),
          report_(report) {}

    void run(std::unique_ptr<ByteSource> source) {
        const Surface surface(Repository::open(std::move(source)), options_.memory_bytes);
        int threads =
            options_.threads > 0 ? options_.threads : static_cast<int>(std::thread::hardware_concurrency());
        threads = std::clamp<int>(threads, 1, 256);
        std::vector<std::thread> crew;
        for (int k = 1; k < threads; ++k) crew.emplace_back([&] { work(surface); });
        work(surface);
        for (std::thread& t : crew) t.join();
        if (failure_) std::rethrow_exception(failure_);
    }

  private:
    void work(const Surface& surface) {
        DiamondCheck check(surface, findings_);
        try {
            for (std::size_t k = next_++; k < parts_.size() && !stop_; k = next_++) look_at(parts_[k], check);
        } catch (...) {
            const std::lock_guard lock(mutex_);
            if (!failure_) failure_ = std::current_exception();
            stop_ = true;
        }
        const std::lock_guard lock(mutex_);
        report_.decoded += check.decoded;
        report_.unreachable += check.unreachable;
        report_.heights += check.heights;
        report_.shared_heights += check.shared;
    }
    void look_at(const PartEntry& e, DiamondCheck& check) {
        const PagePart part = structure_.part(e);
        const DiamondId square = *page_square(e.key);
        std::uint64_t looked_at = 0;
        const auto one = [&](DiamondId d) {
            if (stop_) return false;
            check.check(d);
            tick();
            ++looked_at;
            return true;
        };
        if (!part.is_zero_page()) {
            for (const PageDiamond& d : part.diamonds()) one(slot_diamond(square, d.slot));
            return;
        }
        visit_zero_diamonds(e.key, part.zero().end_level,
                            [&](DiamondId d) { return looked_at < options_.zero_page_limit && one(d); });
        FileCensus all;
        count(all, e, part);
        const std::lock_guard lock(mutex_);
        report_.zero_skipped += all.refined - looked_at;
    }
    void tick() {
        constexpr std::uint64_t kEvery = 256;
        const std::uint64_t done = ++done_;
        if (!options_.progress || done % kEvery != 0) return;
        const std::lock_guard lock(mutex_);
        if (!stop_ && !options_.progress(done, report_.census.refined))
            throw Error(ErrorCode::usage, "cancelled");
    }

    const FileStructure& structure_;
    std::vector<PartEntry> parts_;
    const VerifyOptions& options_;
    Findings& findings_;
    VerifyReport& report_;
    std::atomic<std::size_t> next_{0};
    std::atomic<std::uint64_t> done_{0};
    std::atomic<bool> stop_{false};
    std::mutex mutex_;
    std::exception_ptr failure_;
};

void compare_with_header(const FileStructure& structure, const FileCensus& census, Findings& findings) {
    const RepositoryHeader& h = structure.header().info;
    if (census.refined != h.refined_diamonds)
        findings.add("the pages refine " + std::to_string(census.refined) + " diamonds, the header says " +
                     std::to_string(h.refined_diamonds));
    if (static_cast<int>(census.levels.size()) != h.deepest_level)
        findings.add("the deepest level of the pages is " + std::to_string(census.levels.size()) +
                     ", the header says " + std::to_string(h.deepest_level));
}

}  // namespace

VerifyReport verify_file(const std::filesystem::path& file, const VerifyOptions& options) {
    return verify_source([&] { return open_file(file); }, options);
}

VerifyReport verify_source(const OpenSource& open, const VerifyOptions& options) {
    const auto begin = std::chrono::steady_clock::now();
    VerifyReport report;
    Findings findings(options.damage_limit);
    const std::unique_ptr<ByteSource> source = open();
    std::optional<FileStructure> structure;
    try {
        structure.emplace(*source);
    } catch (const Error& error) {
        if (error.code() == ErrorCode::io) throw;
        findings.add(error.what());
    }
    if (structure) {
        structure->check_layout(
            [&](const std::string& what) { report.remarks.push_back(source->name() + ": " + what); });
        report.census = structure->empty_census();
        std::vector<PartEntry> sound = PageCheck(*structure, findings, report.census).run();
        compare_with_header(*structure, report.census, findings);
        Decoding(*structure, std::move(sound), options, findings, report).run(open());
    }
    findings.tell(report);
    report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return report;
}

}  // namespace carat
