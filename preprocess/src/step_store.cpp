#include "step_store.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/uio.h>
#include <tbb/parallel_for.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <optional>
#include <system_error>

#include "carat/globe/error.hpp"

namespace carat {
namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t kMagic = 0x3150455453544143u;  // "CATSTEP1"
constexpr std::size_t kMaxOpen = 64;
constexpr std::array<const char*, 5> kNames{"vertices", "reference", "heights", "code", "facts"};
constexpr const char* kLockName = "lock";
constexpr const char* kInputsName = "inputs.json";
constexpr const char* kUnfinished = ".unfinished";

struct FileHead {
    std::uint64_t magic, key;
    std::uint32_t kind, level;
    std::uint64_t step;
    std::uint64_t count, length, checksum;
};
static_assert(sizeof(FileHead) == 56);

std::string megabytes(std::uint64_t bytes) {
    return std::to_string((bytes + (std::uint64_t{1} << 20) - 1) >> 20) + " MiB";
}

class Descriptor {
  public:
    explicit Descriptor(int fd) : fd_(fd) {}
    ~Descriptor() {
        if (fd_ >= 0) ::close(fd_);
    }
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    int get() const { return fd_; }

  private:
    int fd_;
};

bool read_fully(int fd, void* out, std::size_t length, std::uint64_t offset) {
    auto* at = static_cast<char*>(out);
    while (length > 0) {
        const ssize_t n = ::pread(fd, at, length, static_cast<off_t>(offset));
        if (n < 0 && errno == EINTR) continue;
        if (n <= 0) return false;
        at += n;
        offset += static_cast<std::uint64_t>(n);
        length -= static_cast<std::size_t>(n);
    }
    return true;
}

bool write_fully(int fd, std::span<iovec> parts) {
    constexpr std::size_t kMost = 512;  // parts a call; IOV_MAX is 1024 on Linux
    while (!parts.empty()) {
        ssize_t n = ::writev(fd, parts.data(), static_cast<int>(std::min(parts.size(), kMost)));
        if (n < 0 && errno == EINTR) continue;
        if (n < 0) return false;
        while (!parts.empty() && static_cast<std::size_t>(n) >= parts.front().iov_len) {
            n -= static_cast<ssize_t>(parts.front().iov_len);
            parts = parts.subspan(1);
        }
        if (n == 0 || parts.empty()) continue;
        parts.front().iov_base = static_cast<char*>(parts.front().iov_base) + n;
        parts.front().iov_len -= static_cast<std::size_t>(n);
    }
    return true;
}

// "heights-12-3"
std::optional<StepKey> parse_name(const std::string& name) {
    for (std::size_t k = 0; k < kNames.size(); ++k) {
        const std::string prefix = std::string(kNames[k]) + "-";
        if (!name.starts_with(prefix)) continue;
        StepKey key{static_cast<StepKind>(k), 0, 0};
        unsigned long long step = 0;
        int used = 0;
        if (std::sscanf(name.c_str() + prefix.size(), "%d-%llu%n", &key.level, &step, &used) != 2 ||
            prefix.size() + static_cast<std::size_t>(used) != name.size())
            return std::nullopt;
        key.step = step;
        return key;
    }
    return std::nullopt;
}

}  // namespace

struct StepStore::OpenFile {
    explicit OpenFile(int fd) : descriptor(fd) {}
    Descriptor descriptor;
    std::vector<std::uint32_t> offsets;
};

StepStore::StepStore(fs::path folder, std::uint64_t key, bool resume, std::uint64_t expected_bytes)
    : folder_(std::move(folder)), key_(key), expected_bytes_(expected_bytes) {
    std::error_code failed;
    fs::create_directories(folder_, failed);
    if (failed)
        throw Error(ErrorCode::io, folder_.string() + ": cannot make this folder: " + failed.message());
    lock_ = ::open((folder_ / kLockName).c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0644);
    if (lock_ < 0) fail(folder_ / kLockName, errno);
    if (::flock(lock_, LOCK_EX | LOCK_NB) != 0) {
        ::close(lock_);
        throw Error(ErrorCode::usage, folder_.string() + ": in use by another build of the same output");
    }
    try {
        if (resume)
            take_over();
        else
            drop_all();
    } catch (...) {
        ::close(lock_);
        throw;
    }
}

StepStore::~StepStore() {
    if (lock_ >= 0) ::close(lock_);
}

void StepStore::fail(const fs::path& path, int error) const {
    if (error == ENOSPC || error == EDQUOT) {
        std::error_code ignored;
        const fs::space_info space = fs::space(folder_, ignored);
        throw Error(ErrorCode::io, path.string() +
                                       ": no space left: the temporary data of this build need about " +
                                       megabytes(expected_bytes_) + ", of which " + megabytes(bytes()) +
                                       " are written and " + megabytes(ignored ? 0 : space.available) +
                                       " are free; make room or name another disk with --temp");
    }
    throw Error(ErrorCode::io, path.string() + ": " + std::strerror(error));
}

fs::path StepStore::path_of(const StepKey& key) const {
    return folder_ / (std::string(kNames[static_cast<std::size_t>(key.kind)]) + "-" +
                      std::to_string(key.level) + "-" + std::to_string(key.step));
}

bool StepStore::sound(const fs::path& path, const StepKey& key) const {
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    if (file.get() < 0) return false;
    FileHead head;
    if (!read_fully(file.get(), &head, sizeof head, 0)) return false;
    std::error_code failed;
    if (head.magic != kMagic || head.key != key_ || head.kind != static_cast<std::uint32_t>(key.kind) ||
        head.level != static_cast<std::uint32_t>(key.level) || head.step != key.step ||
        fs::file_size(path, failed) != sizeof head + head.length || failed)
        return false;
    std::vector<std::byte> body(head.length);
    return read_fully(file.get(), body.data(), body.size(), sizeof head) &&
           XXH3_64bits(body.data(), body.size()) == head.checksum;
}

void StepStore::take_over() {
    std::vector<std::pair<fs::path, std::optional<StepKey>>> files;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_))
        if (entry.path().filename() != kLockName && entry.path().filename() != kInputsName)
            files.emplace_back(entry.path(), parse_name(entry.path().filename().string()));
    tbb::parallel_for(std::size_t{0}, files.size(), [&](std::size_t k) {
        auto& [path, key] = files[k];
        if (key && sound(path, *key)) return;
        key.reset();
        std::error_code ignored;
        if (fs::is_regular_file(path)) fs::remove(path, ignored);
    });
    for (const auto& [path, key] : files) {
        if (!key) continue;
        present_.insert(*key);
        bytes_ += fs::file_size(path);
    }
    found_ = present_.size();
    peak_bytes_ = bytes_;
}

bool StepStore::has(const StepKey& key) const {
    const std::lock_guard lock(mutex_);
    return present_.contains(key);
}

std::uint64_t StepStore::bytes() const {
    const std::lock_guard lock(mutex_);
    return bytes_;
}

std::uint64_t StepStore::peak_bytes() const {
    const std::lock_guard lock(mutex_);
    return peak_bytes_;
}

void StepStore::put(const StepKey& key, const StepRecords& records) {
    std::vector<std::uint32_t> offsets{0};
    for (const auto& r : records) offsets.push_back(offsets.back() + static_cast<std::uint32_t>(r.size()));
    const std::unique_ptr<XXH3_state_t, decltype(&XXH3_freeState)> hash(XXH3_createState(), &XXH3_freeState);
    XXH3_64bits_reset(hash.get());
    XXH3_64bits_update(hash.get(), offsets.data(), 4 * offsets.size());
    for (const auto& r : records) XXH3_64bits_update(hash.get(), r.data(), r.size());
    FileHead head{
        kMagic,   key_,           static_cast<std::uint32_t>(key.kind), static_cast<std::uint32_t>(key.level),
        key.step, records.size(), 4 * offsets.size() + offsets.back(),  XXH3_64bits_digest(hash.get())};
    std::vector<iovec> parts{{&head, sizeof head}, {offsets.data(), 4 * offsets.size()}};
    for (const auto& r : records)
        if (!r.empty()) parts.push_back({const_cast<std::byte*>(r.data()), r.size()});
    write_file(path_of(key), parts);
    const std::lock_guard lock(mutex_);
    present_.insert(key);
    bytes_ += sizeof head + head.length;
    peak_bytes_ = std::max(peak_bytes_, bytes_);
}

void StepStore::write_file(const fs::path& path, std::span<iovec> parts) const {
    const fs::path unfinished = path.string() + kUnfinished;
    {
        const Descriptor file(::open(unfinished.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644));
        if (file.get() < 0) fail(unfinished, errno);
        if (!write_fully(file.get(), parts)) {
            const int error = errno;
            ::unlink(unfinished.c_str());
            fail(path, error);
        }
    }
    if (::rename(unfinished.c_str(), path.c_str()) != 0) fail(path, errno);
}

StepStore::FilePtr StepStore::open(const StepKey& key) {
    const std::lock_guard lock(mutex_);
    const auto it = std::find_if(open_.begin(), open_.end(), [&](const auto& f) { return f.first == key; });
    if (it != open_.end()) {
        open_.splice(open_.begin(), open_, it);
        return open_.front().second;
    }
    const fs::path path = path_of(key);
    const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
    if (fd < 0) fail(path, errno);
    auto file = std::make_shared<OpenFile>(fd);
    FileHead head;
    if (!read_fully(fd, &head, sizeof head, 0) || head.magic != kMagic || head.key != key_)
        throw Error(ErrorCode::io, path.string() + ": has been changed by someone else");
    file->offsets.resize(head.count + 1);
    if (!read_fully(fd, file->offsets.data(), 4 * file->offsets.size(), sizeof head)) fail(path, EIO);
    open_.emplace_front(key, file);
    if (open_.size() > kMaxOpen) open_.pop_back();
    return file;
}

void StepStore::read(const StepKey& key, std::size_t index, std::vector<std::byte>& out) {
    const FilePtr file = open(key);
    if (index + 1 >= file->offsets.size()) fail(path_of(key), EIO);
    const std::uint32_t begin = file->offsets[index], end = file->offsets[index + 1];
    out.resize(end - begin);
    if (!read_fully(file->descriptor.get(), out.data(), out.size(),
                    sizeof(FileHead) + 4 * file->offsets.size() + begin))
        fail(path_of(key), EIO);
}

void StepStore::expect(const StepKey& key) noexcept {
    try {
        if (has(key)) ::posix_fadvise(open(key)->descriptor.get(), 0, 0, POSIX_FADV_WILLNEED);
    } catch (const std::exception&) {  // whoever reads the file will say what is wrong
    }
}

StepRecords StepStore::read_all(const StepKey& key) {
    const FilePtr file = open(key);
    StepRecords out(file->offsets.size() - 1);
    for (std::size_t k = 0; k < out.size(); ++k) read(key, k, out[k]);
    return out;
}

void StepStore::drop(StepKind kind, int level) {
    const std::lock_guard lock(mutex_);
    const auto matches = [&](const StepKey& key) { return key.kind == kind && key.level == level; };
    std::erase_if(open_, [&](const auto& f) { return matches(f.first); });
    std::error_code ignored;
    for (auto it = present_.lower_bound({kind, level, 0}); it != present_.end() && matches(*it);) {
        const std::uint64_t size = fs::file_size(path_of(*it), ignored);
        if (!ignored) bytes_ -= std::min(bytes_, size);
        fs::remove(path_of(*it), ignored);
        it = present_.erase(it);
    }
}

void StepStore::drop_all() {
    const std::lock_guard lock(mutex_);
    open_.clear();
    present_.clear();
    bytes_ = 0;
    found_ = 0;
    std::error_code ignored;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder_)) {
        std::string name = entry.path().filename().string();
        if (name.ends_with(kUnfinished)) name.resize(name.size() - std::strlen(kUnfinished));
        if (parse_name(name)) fs::remove(entry.path(), ignored);
    }
}

void StepStore::remove() {
    drop_all();
    std::error_code ignored;
    fs::remove(folder_ / kInputsName, ignored);
    fs::remove(folder_ / kLockName, ignored);
    fs::remove(folder_, ignored);  // unless someone has put files there
}

}  // namespace carat
