// The temporary files of a build: one file a step, which is there only when it is complete and sound.
//
//   file     magic, key of the build, kind, level, step, count, length, XXH3 of what follows;
//            then offsets (count + 1, u32) and records
//   writing  to a name of its own, then renamed: a file under its name is complete but for a crash of the
//   machine trust    files left by an earlier run count only with resume, and only if key, length and
//   checksum are right
//
// What is written depends on the build alone, never on threads or memory.
#pragma once

#include <sys/uio.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <list>
#include <memory>
#include <mutex>
#include <set>
#include <span>
#include <string>
#include <tuple>
#include <vector>

namespace carat {

// What a step leaves behind, a record for each of its diamonds.
enum class StepKind : std::uint32_t {
    vertices,   // reference heights of vertices, for the level above
    reference,  // reference heights that are to be coded
    heights,    // reconstructed heights, for the levels below
    code,       // coded residuals
    facts,      // what the summaries are made of
};

struct StepKey {
    StepKind kind = StepKind::vertices;
    int level = 0;
    std::size_t step = 0;

    friend auto operator<=>(const StepKey&, const StepKey&) = default;
};

using StepRecords = std::vector<std::vector<std::byte>>;

// Thread-safe.
class StepStore {
  public:
    // Makes the folder. resume: keeps the files of the same key that are sound; otherwise, and all others,
    // are removed. Throws Error(usage) if another process uses the folder, Error(io).
    StepStore(std::filesystem::path folder, std::uint64_t key, bool resume, std::uint64_t expected_bytes);
    // Leaves the folder as it is.
    ~StepStore();
    StepStore(const StepStore&) = delete;
    StepStore& operator=(const StepStore&) = delete;

    bool has(const StepKey& key) const;
    // Throws Error(io); a full disk says what the build needs.
    void put(const StepKey& key, const StepRecords& records);
    // Record `index` of a step. Throws Error(io).
    void read(const StepKey& key, std::size_t index, std::vector<std::byte>& out);
    // The file of a step is going to be read: lets the system fetch it meanwhile. A hint; never fails.
    void expect(const StepKey& key) noexcept;
    // All records of a step.
    StepRecords read_all(const StepKey& key);
    // Removes the files of a kind and level.
    void drop(StepKind kind, int level);
    void drop_all();
    // Removes the folder.
    void remove();

    const std::filesystem::path& folder() const { return folder_; }
    std::uint64_t bytes() const;                  // now
    std::uint64_t peak_bytes() const;             // of this run
    std::size_t found() const { return found_; }  // files taken over from an earlier run

  private:
    struct OpenFile;
    using FilePtr = std::shared_ptr<OpenFile>;

    std::filesystem::path path_of(const StepKey& key) const;
    void take_over();
    bool sound(const std::filesystem::path& path, const StepKey& key) const;
    FilePtr open(const StepKey& key);
    void write_file(const std::filesystem::path& path, std::span<iovec> parts) const;
    [[noreturn]] void fail(const std::filesystem::path& path, int error) const;

    std::filesystem::path folder_;
    std::uint64_t key_;
    std::uint64_t expected_bytes_;
    int lock_ = -1;
    mutable std::mutex mutex_;
    std::set<StepKey> present_;
    std::list<std::pair<StepKey, FilePtr>> open_;  // latest first
    std::uint64_t bytes_ = 0, peak_bytes_ = 0;
    std::size_t found_ = 0;
};

}  // namespace carat
