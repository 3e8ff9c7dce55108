#include "scratch_folder.hpp"

#include <unistd.h>

namespace carat::cli {

ScratchFolder::ScratchFolder(const std::string& name, const std::filesystem::path& parent)
    : path_((parent.empty() ? std::filesystem::temp_directory_path() : parent) /
            ("carat-" + name + "-" + std::to_string(getpid()))) {
    std::filesystem::create_directories(path_);
}

ScratchFolder::~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
}

}  // namespace carat::cli
