// The container of three planes: docs/format.md, section 15.
#include <algorithm>
#include <fstream>
#include <vector>

#include "carat/codec/byte_source.hpp"
#include "carat/codec/colour.hpp"
#include "carat/globe/error.hpp"
#include "file_header.hpp"

namespace carat {
namespace {

constexpr std::array<char, 8> kColourMagic{'C', 'A', 'R', 'A', 'T', 'R', 'G', 'B'};
constexpr std::uint32_t kColourVersion = 1;
constexpr std::size_t kColourHeadBytes = 48;  // magic, version, tolerance, three lengths, checksum

struct Head {
    int tolerance = 0;
    std::array<std::uint64_t, kColourPlanes> lengths{};
};

void put(std::vector<std::byte>& out, std::uint64_t value, int bytes) {
    for (int k = 0; k < bytes; ++k) out.push_back(static_cast<std::byte>(value >> (8 * k) & 255));
}

std::uint64_t take(std::span<const std::byte> in, std::size_t at, int bytes) {
    std::uint64_t value = 0;
    for (int k = 0; k < bytes; ++k)
        value |= std::to_integer<std::uint64_t>(in[at + static_cast<std::size_t>(k)]) << (8 * k);
    return value;
}

std::vector<std::byte> encode(const Head& head) {
    std::vector<std::byte> out;
    for (const char c : kColourMagic) out.push_back(static_cast<std::byte>(c));
    put(out, kColourVersion, 4);
    put(out, static_cast<std::uint64_t>(head.tolerance), 4);
    for (const std::uint64_t length : head.lengths) put(out, length, 8);
    put(out, checksum_of(out), 8);
    return out;
}

bool has_magic(std::span<const std::byte> bytes) {
    return std::equal(kColourMagic.begin(), kColourMagic.end(), bytes.begin(),
                      [](char c, std::byte b) { return static_cast<std::byte>(c) == b; });
}

Head decode(const ByteSource& source) {
    std::array<std::byte, kColourHeadBytes> bytes;
    source.read(0, bytes);
    const auto refuse = [&](ErrorCode code, const std::string& what) {
        throw Error(code, source.name() + ": " + what);
    };
    if (!has_magic(bytes)) refuse(ErrorCode::corrupt, "is not a Carat colour file");
    if (const auto version = take(bytes, 8, 4); version != kColourVersion)
        refuse(ErrorCode::unsupported, "colour files of version " + std::to_string(version) +
                                           "; this program reads version " + std::to_string(kColourVersion));
    if (take(bytes, 40, 8) != checksum_of(std::span(bytes).first(40)))
        refuse(ErrorCode::corrupt, "the colour header fails its checksum");
    Head head;
    const std::uint64_t tolerance = take(bytes, 12, 4);
    if (tolerance > 255) refuse(ErrorCode::corrupt, "a colour tolerance above 255");
    head.tolerance = static_cast<int>(tolerance);
    std::uint64_t rest = source.size() - kColourHeadBytes;
    for (std::size_t k = 0; k < kColourPlanes; ++k) {
        head.lengths[k] = take(bytes, 16 + 8 * k, 8);
        if (head.lengths[k] > rest) refuse(ErrorCode::truncated, "ends within its planes");
        rest -= head.lengths[k];
    }
    if (rest != 0) refuse(ErrorCode::corrupt, std::to_string(rest) + " bytes behind its planes");
    return head;
}

// A part of a file that several share.
class Section final : public ByteSource {
  public:
    Section(std::shared_ptr<const ByteSource> whole, std::uint64_t begin, std::uint64_t size,
            const char* plane)
        : whole_(std::move(whole)), begin_(begin), size_(size), name_(whole_->name() + " (" + plane + ")") {}

    const std::string& name() const override { return name_; }
    std::uint64_t size() const override { return size_; }
    void read(std::uint64_t offset, std::span<std::byte> out) const override {
        if (offset > size_ || out.size() > size_ - offset)
            throw Error(ErrorCode::truncated,
                        name_ + ": ends before byte " + std::to_string(offset + out.size()));
        whole_->read(begin_ + offset, out);
    }

  private:
    std::shared_ptr<const ByteSource> whole_;
    std::uint64_t begin_, size_;
    std::string name_;
};

}  // namespace

bool is_colour_file(const std::filesystem::path& file) {
    std::array<std::byte, kColourMagic.size()> bytes;
    std::ifstream in(file, std::ios::binary);
    in.read(reinterpret_cast<char*>(bytes.data()), bytes.size());
    return in.good() && has_magic(bytes);
}

std::array<std::unique_ptr<ByteSource>, kColourPlanes> open_colour_planes(const std::filesystem::path& file) {
    const std::shared_ptr<const ByteSource> whole = open_file(file);
    const Head head = decode(*whole);
    constexpr std::array names{"Y", "Co", "Cg"};
    std::array<std::unique_ptr<ByteSource>, kColourPlanes> out;
    std::uint64_t begin = kColourHeadBytes;
    for (std::size_t k = 0; k < kColourPlanes; ++k) {
        out[k] = std::make_unique<Section>(whole, begin, head.lengths[k], names[k]);
        begin += head.lengths[k];
    }
    return out;
}

int colour_tolerance(const std::filesystem::path& file) { return decode(*open_file(file)).tolerance; }

void write_colour_file(const std::filesystem::path& file,
                       const std::array<std::filesystem::path, kColourPlanes>& planes, int tolerance) {
    Head head;
    head.tolerance = tolerance;
    for (std::size_t k = 0; k < kColourPlanes; ++k) head.lengths[k] = std::filesystem::file_size(planes[k]);
    std::filesystem::path partial = file;
    partial += ".partial";
    std::ofstream out(partial, std::ios::binary | std::ios::trunc);
    const std::vector<std::byte> bytes = encode(head);
    out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
    for (const std::filesystem::path& plane : planes) out << std::ifstream(plane, std::ios::binary).rdbuf();
    out.close();
    std::error_code failed;
    const std::uint64_t size = head.lengths[0] + head.lengths[1] + head.lengths[2] + kColourHeadBytes;
    if (!out || std::filesystem::file_size(partial, failed) != size || failed) {
        std::filesystem::remove(partial, failed);
        throw Error(ErrorCode::io, file.string() + ": cannot write");
    }
    std::filesystem::rename(partial, file, failed);
    if (failed) throw Error(ErrorCode::io, file.string() + ": cannot rename into place: " + failed.message());
}

}  // namespace carat
