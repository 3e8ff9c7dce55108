// The file of compiled pipelines: read back if it is ours and whole, ignored otherwise.
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>

#include "pipelines.hpp"

namespace carat::vk {

namespace {

namespace fs = std::filesystem;

class PipelineCache : public ::testing::Test {
  protected:
    Instance instance{true};
    Device device{instance, ""};
    fs::path folder =
        fs::temp_directory_path() /
        ("carat-pipelines-" + std::to_string(::testing::UnitTest::GetInstance()->random_seed()) + "-" +
         std::to_string(::getpid()));

    void TearDown() override {
        fs::remove_all(folder);
        EXPECT_TRUE(instance.messages().empty()) << instance.messages()[0];
    }
    fs::path only_file() const {
        const fs::directory_iterator files(folder), end;
        EXPECT_EQ(std::distance(fs::directory_iterator(folder), end), 1);
        return files->path();
    }
    std::vector<std::byte> plausible() const {
        VkPipelineCacheHeaderVersionOne header{sizeof(header),
                                               VK_PIPELINE_CACHE_HEADER_VERSION_ONE,
                                               device.properties().vendorID,
                                               device.properties().deviceID,
                                               {}};
        std::memcpy(header.pipelineCacheUUID, device.properties().pipelineCacheUUID, VK_UUID_SIZE);
        std::vector<std::byte> data(sizeof(header) + 5);
        std::memcpy(data.data(), &header, sizeof(header));
        return data;
    }
};

TEST_F(PipelineCache, IsWrittenOnceAndReadBack) {
    { Pipelines(device, folder.string()).draw({}); }
    const auto size = fs::file_size(only_file());
    EXPECT_GE(size, 8 + sizeof(VkPipelineCacheHeaderVersionOne));
    {
        const PipelineCacheFile again(device, folder.string());
        EXPECT_EQ(again.bytes_read(), size - 8);
    }
    EXPECT_EQ(fs::file_size(only_file()), size);
}

TEST_F(PipelineCache, DamageAtAnyByteIsNoticed) {
    const auto good = cache_file(plausible());
    ASSERT_EQ(checked_cache(good, device.properties()), plausible());
    for (std::size_t k = 0; k < good.size(); ++k) {
        auto bad = good;
        bad[k] ^= std::byte{1};
        EXPECT_TRUE(checked_cache(bad, device.properties()).empty()) << k;
        bad = good;
        bad.resize(k);
        EXPECT_TRUE(checked_cache(bad, device.properties()).empty()) << k;
    }
}

TEST_F(PipelineCache, OfAnotherDeviceOrDriverIsIgnored) {
    VkPhysicalDeviceProperties other = device.properties();
    other.pipelineCacheUUID[3] ^= 1;
    EXPECT_TRUE(checked_cache(cache_file(plausible()), other).empty());
    other = device.properties();
    other.deviceID ^= 1;
    EXPECT_TRUE(checked_cache(cache_file(plausible()), other).empty());
}

TEST_F(PipelineCache, AFolderThatCannotBeWrittenCostsNothing) {
    EXPECT_NE(Pipelines(device, "/proc/no/such/folder").draw({}), VkPipeline{VK_NULL_HANDLE});
}

TEST_F(PipelineCache, GarbageInTheFileIsReplaced) {
    { Pipelines(device, folder.string()).draw({}); }
    const fs::path file = only_file();
    const auto size = fs::file_size(file);
    std::ofstream(file, std::ios::binary) << "garbage";
    {
        const PipelineCacheFile ignored(device, folder.string());
        EXPECT_EQ(ignored.bytes_read(), 0u);
    }
    EXPECT_LE(fs::file_size(file), size);
    EXPECT_GT(PipelineCacheFile(device, folder.string()).bytes_read(), 0u);
}

}  // namespace

}  // namespace carat::vk
