#include "child_process.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <cstring>
#include <fstream>
#include <iterator>

#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

double seconds_of(const timeval& t) {
    return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// The last of what a program wrote, for an error message.
std::string tail_of(const std::filesystem::path& file) {
    constexpr std::size_t kMost = 400;
    std::ifstream in(file, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(in), {}};
    if (text.size() > kMost) text.erase(0, text.size() - kMost);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    return text;
}

// Where the streams of a child go.
class FileActions {
  public:
    FileActions(const std::filesystem::path& out, const std::filesystem::path& err) {
        posix_spawn_file_actions_init(&actions_);
        add(STDIN_FILENO, "/dev/null", O_RDONLY);
        add(STDOUT_FILENO, out, O_WRONLY | O_CREAT | O_TRUNC);
        add(STDERR_FILENO, err, O_WRONLY | O_CREAT | O_TRUNC);
    }
    ~FileActions() { posix_spawn_file_actions_destroy(&actions_); }
    FileActions(const FileActions&) = delete;
    FileActions& operator=(const FileActions&) = delete;
    const posix_spawn_file_actions_t* get() const { return &actions_; }

  private:
    void add(int fd, const std::filesystem::path& file, int flags) {
        posix_spawn_file_actions_addopen(&actions_, fd, file.c_str(), flags, 0644);
    }
    posix_spawn_file_actions_t actions_{};
};

}  // namespace

ChildUsage run_child(const std::vector<std::string>& arguments, const std::filesystem::path& out,
                     const std::filesystem::path& err) {
    std::vector<char*> argv;
    for (const std::string& a : arguments) argv.push_back(const_cast<char*>(a.c_str()));
    argv.push_back(nullptr);
    const FileActions actions(out, err);
    const auto started = std::chrono::steady_clock::now();
    pid_t pid = 0;
    if (const int failed = ::posix_spawnp(&pid, argv.front(), actions.get(), nullptr, argv.data(), environ))
        throw Error(ErrorCode::io, arguments.front() + ": cannot be run: " + std::strerror(failed));
    int status = 0;
    rusage usage{};
    while (::wait4(pid, &status, 0, &usage) < 0)
        if (errno != EINTR) throw Error(ErrorCode::io, arguments.front() + ": lost: " + std::strerror(errno));
    const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - started;
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw Error(ErrorCode::io, arguments.front() + ": failed: " + tail_of(err));
    return {wall.count(), seconds_of(usage.ru_utime) + seconds_of(usage.ru_stime),
            static_cast<std::uint64_t>(usage.ru_maxrss) * 1024};
}

}  // namespace carat::cli
