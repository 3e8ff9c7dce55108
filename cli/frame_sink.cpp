#include "frame_sink.hpp"

#include <fmt/core.h>

#include <cmath>
#include <csignal>
#include <filesystem>
#include <vector>

#include "carat/globe/error.hpp"

namespace carat::cli {
namespace {

bool ends_with(const std::string& text, const std::string& end) {
    return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// For the shell, in single quotes.
std::string shell_quoted(const std::string& text) {
    std::string out = "'";
    for (const char c : text) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
    return out + "'";
}

// Without coverage, which a film and a PNG of it have no use for.
Picture opaque(const Picture& p) {
    Picture out{p.width, p.height, {"R", "G", "B"}, {}, {}};
    out.values.reserve(p.values.size() / p.channels.size() * 3);
    for (std::size_t k = 0; k < p.values.size(); k += p.channels.size())
        out.values.insert(out.values.end(), {p.values[k], p.values[k + 1], p.values[k + 2]});
    return out;
}

}  // namespace

FrameSink::FrameSink(std::string output, double fps, bool overwrite, const std::string& extension)
    : output_(std::move(output)), extension_(extension), fps_(fps), film_(ends_with(output_, ".mp4")) {
    const bool taken = std::filesystem::exists(film_ ? output_ : file_of(1));
    if (taken && !overwrite)
        throw Error(ErrorCode::usage, output_ + ": exists already; --overwrite replaces it");
    if (film_) return;
    std::error_code failed;
    std::filesystem::create_directories(output_, failed);
    if (failed) throw Error(ErrorCode::io, output_ + ": " + failed.message());
}

FrameSink::~FrameSink() {
    if (pipe_ == nullptr) return;
    pclose(pipe_);
    std::error_code ignored;
    std::filesystem::remove(partial_, ignored);
}

void FrameSink::open_film(const Picture& first) {
    partial_ = output_.substr(0, output_.size() - 4) + ".partial.mp4";
    const std::string command = fmt::format(
        "ffmpeg -loglevel error -y -f rawvideo -pix_fmt rgb24 -s {}x{} -r {} -i - -an -c:v libx264 -preset "
        "medium "
        "-crf 20 -pix_fmt yuv420p -vf 'pad=ceil(iw/2)*2:ceil(ih/2)*2' -movflags +faststart {}",
        first.width, first.height, fps_, shell_quoted(partial_));
    std::signal(SIGPIPE, SIG_IGN);  // a dead ffmpeg is an error of fwrite
    pipe_ = popen(command.c_str(), "w");
    if (pipe_ == nullptr) throw Error(ErrorCode::io, output_ + ": cannot start ffmpeg");
}

std::string FrameSink::file_of(int frame) const {
    return (std::filesystem::path(output_) / fmt::format("frame-{:05}.{}", frame, extension_)).string();
}

void FrameSink::add(const Picture& colour) {
    ++frames_;
    if (!film_) {
        write_picture(file_of(frames_), extension_ == "exr" ? colour : opaque(colour));
        return;
    }
    if (pipe_ == nullptr) open_film(colour);
    std::vector<unsigned char> row(static_cast<std::size_t>(colour.width) * 3);
    for (int y = 0; y < colour.height; ++y) {
        for (int x = 0; x < colour.width; ++x)
            for (int c = 0; c < 3; ++c)
                row[static_cast<std::size_t>(3 * x + c)] =
                    static_cast<unsigned char>(std::lround(255 * srgb_encode(colour.at(x, y)[c])));
        if (std::fwrite(row.data(), 1, row.size(), pipe_) != row.size())
            throw Error(ErrorCode::io, output_ + ": ffmpeg ended early");
    }
}

void FrameSink::finish() {
    if (pipe_ == nullptr) return;
    const int status = pclose(pipe_);
    pipe_ = nullptr;
    std::error_code failed;
    if (status == 0) std::filesystem::rename(partial_, output_, failed);
    if (status != 0 || failed)
        throw Error(ErrorCode::io, fmt::format("{}: ffmpeg failed (status {})", output_, status));
}

}  // namespace carat::cli
