// What a dataset's files contain, in one number.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace carat {

struct ContentHash {
    std::uint64_t hash = 0;   // XXH3-64 of the files' bytes, one after the other
    std::uint64_t bytes = 0;  // in all
};

// Reads all files through GDAL's virtual file systems; names that are no files (folders, database tables) are
// left out. Throws Error(io) naming the file.
ContentHash content_hash(const std::vector<std::string>& files);

// The bytes alone; hash is 0. Reads nothing.
ContentHash content_size(const std::vector<std::string>& files);

}  // namespace carat
