// Descriptor layout and pipelines; variants are made when first asked for.
#pragma once

#include <map>
#include <span>
#include <tuple>

#include "pipeline_cache_file.hpp"
#include "shaders.hpp"

namespace carat::vk {

inline constexpr VkFormat kColourFormat = VK_FORMAT_R16G16B16A16_SFLOAT;
inline constexpr VkFormat kDepthFormat = VK_FORMAT_D32_SFLOAT;
inline constexpr VkFormat kPositionFormat = VK_FORMAT_R32G32B32A32_SFLOAT;  // and depth
inline constexpr VkFormat kNormalFormat = VK_FORMAT_R32G32B32A32_SFLOAT;    // and height
inline constexpr VkFormat kPatchFormat = VK_FORMAT_R32G32B32A32_UINT;       // half (two), triangle

// One pass over the patches.
struct PassKind {
    bool colour = true, aovs = false;
    VkSampleCountFlagBits samples = VK_SAMPLE_COUNT_1_BIT;
    bool cull_back_faces = true;
    bool sky = false, water = false, drape = false, shadows = false;  // in colour

    auto key() const {
        return std::tuple(colour, aovs, int(samples), cull_back_faces, sky, water, drape, shadows);
    }
};

struct ProbeRange {
    std::uint32_t slot, vertex_count;
};

// All of these throw as check() does.
VkDescriptorSetLayoutBinding one_binding(std::uint32_t slot, VkDescriptorType type,
                                         VkShaderStageFlags stages);
SetLayout make_set_layout(VkDevice device, std::span<const VkDescriptorSetLayoutBinding> bindings);
// Of one set, and push constants of compute shaders.
PipelineLayout make_layout(VkDevice device, VkDescriptorSetLayout set, std::uint32_t push_bytes);
ShaderModule make_shader(VkDevice device, Spirv code);

class Pipelines {
  public:
    // cache_folder: where compiled pipelines are kept between runs; empty: nowhere.
    Pipelines(const Device& device, const std::string& cache_folder);

    VkDescriptorSetLayout set_layout() const { return set_layout_.get(); }
    VkPipelineLayout layout() const { return layout_.get(); }
    VkPipeline draw(const PassKind& kind);
    // What is drawn behind the terrain of a pass that has a sky or water.
    VkPipeline background(const PassKind& kind);
    VkPipeline probe();

  private:
    enum class Draws { terrain, background };
    Pipeline make_draw(const PassKind& kind, Draws what) const;
    Pipeline make_probe() const;

    const Device& device_;
    SetLayout set_layout_;
    PipelineLayout layout_;
    PipelineCacheFile cache_;
    std::map<decltype(PassKind{}.key()), Pipeline> draws_, backgrounds_;
    Pipeline probe_;
};

}  // namespace carat::vk
