#include "pipeline_cache_file.hpp"

#include <fmt/core.h>
#include <unistd.h>
#include <xxhash.h>

#include <cstring>
#include <filesystem>
#include <fstream>

namespace carat::vk {

namespace {

namespace fs = std::filesystem;
constexpr std::size_t kHashBytes = 8, kGreatestFile = std::size_t{256} << 20;

std::uint64_t hash(const std::byte* bytes, std::size_t size) { return XXH3_64bits(bytes, size); }

std::string file_name(const VkPhysicalDeviceProperties& p) {
    std::string name =
        fmt::format("pipelines-{:08x}-{:08x}-{:08x}-", p.vendorID, p.deviceID, p.driverVersion);
    for (const std::uint8_t byte : p.pipelineCacheUUID) name += fmt::format("{:02x}", byte);
    return name + ".bin";
}

std::vector<std::byte> read_file(const std::string& path) {
    std::error_code failed;
    const auto size = fs::file_size(path, failed);
    if (failed || size > kGreatestFile) return {};
    std::vector<std::byte> bytes(size);
    std::ifstream in(path, std::ios::binary);
    if (!in.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size))) return {};
    return bytes;
}

}  // namespace

std::vector<std::byte> cache_file(const std::vector<std::byte>& data) {
    std::vector<std::byte> file(kHashBytes + data.size());
    const std::uint64_t h = hash(data.data(), data.size());
    std::memcpy(file.data(), &h, kHashBytes);
    std::copy(data.begin(), data.end(), file.begin() + kHashBytes);
    return file;
}

std::vector<std::byte> checked_cache(const std::vector<std::byte>& file,
                                     const VkPhysicalDeviceProperties& device) {
    VkPipelineCacheHeaderVersionOne header;
    if (file.size() < kHashBytes + sizeof(header)) return {};
    std::uint64_t stored = 0;
    std::memcpy(&stored, file.data(), kHashBytes);
    if (stored != hash(file.data() + kHashBytes, file.size() - kHashBytes)) return {};
    std::memcpy(&header, file.data() + kHashBytes, sizeof(header));
    const bool ours = header.headerSize >= sizeof(header) &&
                      header.headerVersion == VK_PIPELINE_CACHE_HEADER_VERSION_ONE &&
                      header.vendorID == device.vendorID && header.deviceID == device.deviceID &&
                      std::memcmp(header.pipelineCacheUUID, device.pipelineCacheUUID, VK_UUID_SIZE) == 0;
    if (!ours) return {};
    return {file.begin() + kHashBytes, file.end()};
}

PipelineCacheFile::PipelineCacheFile(const Device& device, const std::string& folder) : device_(device) {
    std::vector<std::byte> data;
    if (!folder.empty()) {
        path_ = (fs::path(folder) / file_name(device.properties())).string();
        data = checked_cache(read_file(path_), device.properties());
        bytes_read_ = data.size();
    }
    const VkPipelineCacheCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_CACHE_CREATE_INFO,
                                         .initialDataSize = data.size(),
                                         .pInitialData = data.data()};
    VkPipelineCache cache = VK_NULL_HANDLE;
    check(vkCreatePipelineCache(device.get(), &info, nullptr, &cache), "creating a pipeline cache");
    cache_ = {device.get(), cache};
}

PipelineCacheFile::~PipelineCacheFile() {
    if (path_.empty()) return;
    try {
        write();
    } catch (const std::exception&) {  // the next run compiles again
    }
}

void PipelineCacheFile::write() const {
    std::size_t size = 0;
    check(vkGetPipelineCacheData(device_.get(), cache_.get(), &size, nullptr), "reading the pipeline cache");
    if (size <= bytes_read_) return;
    std::vector<std::byte> data(size);
    check(vkGetPipelineCacheData(device_.get(), cache_.get(), &size, data.data()),
          "reading the pipeline cache");
    data.resize(size);

    fs::create_directories(fs::path(path_).parent_path());
    const std::string partial = fmt::format("{}.{}.partial", path_, ::getpid());
    const std::vector<std::byte> bytes = cache_file(data);
    {
        std::ofstream out(partial, std::ios::binary);
        out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        if (!out.flush()) {
            fs::remove(partial);
            return;
        }
    }
    fs::rename(partial, path_);
}

}  // namespace carat::vk
