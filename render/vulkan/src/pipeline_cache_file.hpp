// Compiled pipelines, kept in a file between runs: one a device and driver.
//
//   file     8 bytes XXH3 of the rest, then what vkGetPipelineCacheData gave
//   trusted  only if the hash fits and the driver's own header names this device, driver build included;
//            anything else is as good as no file
#pragma once

#include <string>
#include <vector>

#include "device.hpp"

namespace carat::vk {

class PipelineCacheFile {
  public:
    // An empty folder: nothing is read or written. Never fails for the file's sake.
    PipelineCacheFile(const Device& device, const std::string& folder);
    // Writes the file, under a temporary name first, if there is more in it than was read.
    ~PipelineCacheFile();
    PipelineCacheFile(const PipelineCacheFile&) = delete;
    PipelineCacheFile& operator=(const PipelineCacheFile&) = delete;

    VkPipelineCache get() const { return cache_.get(); }
    std::size_t bytes_read() const { return bytes_read_; }

  private:
    void write() const;

    const Device& device_;
    std::string path_;
    std::size_t bytes_read_ = 0;
    PipelineCache cache_;
};

// The driver's data in the bytes of a cache file; nothing if damaged or of another device.
std::vector<std::byte> checked_cache(const std::vector<std::byte>& file,
                                     const VkPhysicalDeviceProperties& device);
std::vector<std::byte> cache_file(const std::vector<std::byte>& data);

}  // namespace carat::vk
