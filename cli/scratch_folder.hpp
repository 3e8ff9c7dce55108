// A folder of its own, by default in the system's temporary folder, that goes when it is done with.
#pragma once

#include <filesystem>
#include <string>

namespace carat::cli {

class ScratchFolder {
  public:
    // Throws std::filesystem::filesystem_error.
    explicit ScratchFolder(const std::string& name, const std::filesystem::path& parent = {});
    ~ScratchFolder();
    ScratchFolder(const ScratchFolder&) = delete;
    ScratchFolder& operator=(const ScratchFolder&) = delete;
    const std::filesystem::path& path() const { return path_; }

  private:
    std::filesystem::path path_;
};

}  // namespace carat::cli
