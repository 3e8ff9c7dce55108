#include "checksum_repair.hpp"

#include <xxhash.h>

#include <cstddef>
#include <cstring>
#include <optional>

namespace carat::test {
namespace {

// Offsets of docs/format.md, sections 4, 6 and 7.
constexpr std::uint64_t kFixedHeader = 152, kRoots = 80, kDirectory = 104, kBlockEntry = 32, kPartEntry = 24;

class Repair {
  public:
    explicit Repair(std::vector<std::byte>& file) : file_(file) {}

    void run() {
        if (file_.size() < kFixedHeader) return;
        const std::uint64_t offset = get(kDirectory, 8), length = get(kDirectory + 8, 4);
        if (inside(offset, length))
            for (std::uint64_t k = 0; k + kBlockEntry <= length; k += kBlockEntry) block(offset + k);
        extent(kDirectory);
        extent(kRoots);
        const std::uint64_t header = get(12, 4);
        if (header >= kFixedHeader && inside(0, header)) put(header - 8, sum(0, header - 8));
    }

  private:
    bool inside(std::uint64_t offset, std::uint64_t length) const {
        return offset <= file_.size() && length <= file_.size() - offset;
    }
    std::uint64_t get(std::uint64_t at, std::size_t bytes) const {
        std::uint64_t value = 0;
        std::memcpy(&value, file_.data() + at, bytes);
        return value;
    }
    void put(std::uint64_t at, std::uint64_t value) { std::memcpy(file_.data() + at, &value, 8); }
    std::uint64_t sum(std::uint64_t offset, std::uint64_t length) const {
        return XXH3_64bits(file_.data() + offset, length);
    }
    void extent(std::uint64_t at) {
        const std::uint64_t offset = get(at, 8), length = get(at + 8, 4);
        if (inside(offset, length)) put(at + 16, sum(offset, length));
    }
    void block(std::uint64_t at) {
        const std::uint64_t entries = get(at + 12, 4), offset = get(at + 16, 8);
        if (!inside(offset, entries * kPartEntry)) return;
        for (std::uint64_t k = 0; k < entries; ++k) part(offset + k * kPartEntry);
        put(at + 24, sum(offset, entries * kPartEntry));
    }
    void part(std::uint64_t at) {
        const std::uint64_t offset = get(at + 8, 8), length = get(at + 16, 4);
        if (length >= 8 && inside(offset, length)) put(offset, sum(offset + 8, length - 8));
    }

    std::vector<std::byte>& file_;
};

}  // namespace

void repair_checksums(std::vector<std::byte>& file) { Repair(file).run(); }

}  // namespace carat::test
