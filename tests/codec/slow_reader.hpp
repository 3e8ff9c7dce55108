// A slow, plain reader of .carat files, written from docs/format.md alone and in its order. It shares no code
// with codec/ or globe/: only xxHash and the standard library. It checks everything that section 11 does not
// leave unchecked.
#pragma once

#include <array>
#include <compare>
#include <cstdint>
#include <map>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace slow {

// "truncated", "corrupt", "unsupported", "limit": section 11.
struct Refusal : std::runtime_error {
    Refusal(std::string k, const std::string& what)
        : std::runtime_error(k + ": " + what), kind(std::move(k)) {}
    std::string kind;
};

// Section 2.
struct Point {
    std::int64_t x = 0, y = 0, z = 0;
    auto operator<=>(const Point&) const = default;
};

struct Diamond {
    Point c, a, b;
    std::array<Point, 2> x;
    int level = 0;

    static Diamond at(const Point& centre);
    // Twice, to name cell centres: the point at index (i2/2, j2/2), by the formula of half 0 or 1.
    Point point(int half, int i2, int j2, int n) const;
    std::array<Point, 4> children() const;
    std::uint64_t id() const;
};

using Matrix = std::vector<std::int64_t>;

struct Extent {
    std::uint64_t offset = 0, length = 0, checksum = 0;
};

// Section 4.
struct Header {
    std::uint64_t file_bytes = 0, refined = 0;
    double quantum = 0, tolerance = 0, rms = 0, a = 0, b = 0;
    int p = 0, deepest = 0, coder = 0;
    std::vector<std::uint8_t> tables;
    std::int64_t least = 0, greatest = 0;
    Extent roots, directory;
    std::vector<std::int64_t> radii;
    std::string body, datum, provenance;
};

struct Summary {
    std::int64_t least = 0, greatest = 0;  // quanta
    double delta = 0;                      // metres
};

// P of a diamond; entries of an absent half are 0.
struct Heights {
    std::array<bool, 2> has{false, false};
    Matrix p;
};

struct Refined {
    Matrix v, c;
};

class Reader {
  public:
    // built_in: appendix A of the format, the range coder's own tables; needed for files that rely on them.
    explicit Reader(std::vector<std::uint8_t> bytes, std::vector<std::uint8_t> built_in = built_in_tables());
    static std::vector<std::uint8_t> built_in_tables();

    const Header& header() const { return header_; }
    int n() const { return (1 << header_.p) + 1; }
    bool refined(const Point& centre);
    const Heights& heights(const Point& centre);
    const Refined& refine(const Point& centre);
    Summary summary(const Point& centre, int half);

    // What the directory lists; reads every part.
    struct Count {
        int pages = 0, parts = 0, zero_pages = 0;
    };
    Count count();

  private:
    struct PartPlace {
        std::uint64_t key = 0, offset = 0, length = 0;
        int first_slot = 0;
    };
    struct Entry {
        int mode = 0, leaf = 2, order = 4;
        bool gamma = false;
        std::array<Summary, 2> summary{};
        std::vector<std::uint8_t> blob;
    };
    struct Part {
        bool zero = false;
        int first = 0, slots = 77, zero_end = 0;
        std::int64_t least = 0, greatest = 0;
        int delta = 0;
        std::map<int, Entry> entries;
        std::vector<int> zero_delta;
    };
    struct Found {
        const Part* part = nullptr;
        const Entry* entry = nullptr;  // null under a zero page
    };

    void read_header();
    void read_roots();
    void read_directory();
    const Part* part(std::uint64_t key, int slot);
    Part parse_part(const PartPlace& place);
    std::int64_t summary_unit(int level) const;
    std::optional<Found> find(const Point& centre);
    const std::map<Point, std::int64_t>& samples(const Point& centre);

    std::vector<std::uint8_t> bytes_, built_in_;
    std::vector<std::array<std::int64_t, 64>> frequencies_;
    Header header_;
    std::array<Matrix, 6> roots_;
    std::map<std::pair<std::uint64_t, int>, PartPlace> places_;
    std::map<std::pair<std::uint64_t, int>, Part> parts_;
    std::map<Point, Heights> heights_;
    std::map<Point, Refined> refined_;
    std::map<Point, std::map<Point, std::int64_t>>
        samples_;  // of refined diamonds: height at each lattice point
};

}  // namespace slow
