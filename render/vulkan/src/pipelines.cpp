#include "pipelines.hpp"

#include <array>
#include <cstddef>

#include "shaders.hpp"
#include "shared.h"

namespace carat::vk {

namespace {

SetLayout make_terrain_set(VkDevice device) {
    const VkShaderStageFlags vertex = VK_SHADER_STAGE_VERTEX_BIT | VK_SHADER_STAGE_COMPUTE_BIT;
    const std::array bindings{
        one_binding(gpu::kBindFrame, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                    vertex | VK_SHADER_STAGE_FRAGMENT_BIT),
        one_binding(gpu::kBindVertices, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, vertex),
        one_binding(gpu::kBindPatches, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, vertex),
        one_binding(gpu::kBindColours, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, vertex),
        one_binding(gpu::kBindTable, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, VK_SHADER_STAGE_FRAGMENT_BIT),
        one_binding(gpu::kBindProbe, VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, VK_SHADER_STAGE_COMPUTE_BIT),
        one_binding(gpu::kBindTransmittance, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                    VK_SHADER_STAGE_FRAGMENT_BIT),
        one_binding(gpu::kBindMultiple, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                    VK_SHADER_STAGE_FRAGMENT_BIT),
        one_binding(gpu::kBindSkyLight, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                    VK_SHADER_STAGE_FRAGMENT_BIT)};
    return make_set_layout(device, bindings);
}

VkPipelineShaderStageCreateInfo stage(VkShaderStageFlagBits which, const ShaderModule& module) {
    return {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
            .stage = which,
            .module = module.get(),
            .pName = "main"};
}

Spirv fragment_code(const PassKind& kind) {
    if (!kind.aovs) return kTerrainColour;
    return kind.colour ? kTerrainColourAov : kTerrainAov;
}

std::vector<VkFormat> attachment_formats(const PassKind& kind) {
    std::vector<VkFormat> formats;
    if (kind.colour) formats.push_back(kColourFormat);
    if (kind.aovs) formats.insert(formats.end(), {kPositionFormat, kNormalFormat, kPatchFormat});
    return formats;
}

// The specialisation constants of surface.glsl.
struct Features {
    VkBool32 sky, water, drape, shadows;
};
constexpr std::array<VkSpecializationMapEntry, 4> kFeatureEntries{
    {{0, offsetof(Features, sky), sizeof(VkBool32)},
     {1, offsetof(Features, water), sizeof(VkBool32)},
     {2, offsetof(Features, drape), sizeof(VkBool32)},
     {3, offsetof(Features, shadows), sizeof(VkBool32)}}};

}  // namespace

VkDescriptorSetLayoutBinding one_binding(std::uint32_t slot, VkDescriptorType type,
                                         VkShaderStageFlags stages) {
    return {.binding = slot, .descriptorType = type, .descriptorCount = 1, .stageFlags = stages};
}

SetLayout make_set_layout(VkDevice device, std::span<const VkDescriptorSetLayoutBinding> bindings) {
    const VkDescriptorSetLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO,
                                               .bindingCount = static_cast<std::uint32_t>(bindings.size()),
                                               .pBindings = bindings.data()};
    VkDescriptorSetLayout layout = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device, &info, nullptr, &layout), "creating a descriptor layout");
    return {device, layout};
}

PipelineLayout make_layout(VkDevice device, VkDescriptorSetLayout set, std::uint32_t push_bytes) {
    const VkPushConstantRange range{.stageFlags = VK_SHADER_STAGE_COMPUTE_BIT, .size = push_bytes};
    const VkPipelineLayoutCreateInfo info{.sType = VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO,
                                          .setLayoutCount = 1,
                                          .pSetLayouts = &set,
                                          .pushConstantRangeCount = 1,
                                          .pPushConstantRanges = &range};
    VkPipelineLayout layout = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device, &info, nullptr, &layout), "creating a pipeline layout");
    return {device, layout};
}

ShaderModule make_shader(VkDevice device, Spirv code) {
    const VkShaderModuleCreateInfo info{.sType = VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO,
                                        .codeSize = code.size_bytes(),
                                        .pCode = code.data()};
    VkShaderModule module = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device, &info, nullptr, &module), "loading a shader");
    return {device, module};
}

Pipelines::Pipelines(const Device& device, const std::string& cache_folder)
    : device_(device),
      set_layout_(make_terrain_set(device.get())),
      layout_(make_layout(device.get(), set_layout_.get(), sizeof(ProbeRange))),
      cache_(device, cache_folder) {}

VkPipeline Pipelines::draw(const PassKind& kind) {
    Pipeline& pipeline = draws_[kind.key()];
    if (!pipeline) pipeline = make_draw(kind, Draws::terrain);
    return pipeline.get();
}

VkPipeline Pipelines::background(const PassKind& kind) {
    Pipeline& pipeline = backgrounds_[kind.key()];
    if (!pipeline) pipeline = make_draw(kind, Draws::background);
    return pipeline.get();
}

VkPipeline Pipelines::probe() {
    if (!probe_) probe_ = make_probe();
    return probe_.get();
}

Pipeline Pipelines::make_draw(const PassKind& kind, Draws what) const {
    const bool terrain = what == Draws::terrain;
    const ShaderModule vertex = make_shader(device_.get(), terrain ? kTerrainVertex : kSkyVertex);
    const ShaderModule fragment = make_shader(device_.get(), terrain ? fragment_code(kind) : kSkyFragment);
    std::array stages{stage(VK_SHADER_STAGE_VERTEX_BIT, vertex),
                      stage(VK_SHADER_STAGE_FRAGMENT_BIT, fragment)};
    const Features features{kind.sky, kind.water, kind.drape, kind.shadows};
    const VkSpecializationInfo constants{.mapEntryCount = kFeatureEntries.size(),
                                         .pMapEntries = kFeatureEntries.data(),
                                         .dataSize = sizeof(features),
                                         .pData = &features};
    if (terrain) stages[0].pSpecializationInfo = &constants;
    if (kind.colour) stages[1].pSpecializationInfo = &constants;

    const VkPipelineVertexInputStateCreateInfo input{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VERTEX_INPUT_STATE_CREATE_INFO};
    const VkPipelineInputAssemblyStateCreateInfo assembly{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_INPUT_ASSEMBLY_STATE_CREATE_INFO,
        .topology = VK_PRIMITIVE_TOPOLOGY_TRIANGLE_LIST};
    const VkPipelineViewportStateCreateInfo viewport{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_VIEWPORT_STATE_CREATE_INFO,
        .viewportCount = 1,
        .scissorCount = 1};
    const VkPipelineRasterizationStateCreateInfo raster{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RASTERIZATION_STATE_CREATE_INFO,
        .polygonMode = VK_POLYGON_MODE_FILL,
        .cullMode = kind.cull_back_faces && terrain ? VkCullModeFlags{VK_CULL_MODE_BACK_BIT}
                                                    : VkCullModeFlags{VK_CULL_MODE_NONE},
        .frontFace = VK_FRONT_FACE_COUNTER_CLOCKWISE,
        .lineWidth = 1};
    const VkPipelineMultisampleStateCreateInfo samples{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_MULTISAMPLE_STATE_CREATE_INFO,
        .rasterizationSamples = kind.samples};
    const VkPipelineDepthStencilStateCreateInfo depth{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DEPTH_STENCIL_STATE_CREATE_INFO,
        .depthTestEnable = VK_TRUE,
        .depthWriteEnable = terrain,
        .depthCompareOp = terrain ? VK_COMPARE_OP_GREATER : VK_COMPARE_OP_EQUAL};  // reversed

    const std::vector<VkFormat> formats = attachment_formats(kind);
    const VkPipelineColorBlendAttachmentState opaque{.colorWriteMask = 0xF};
    const std::vector<VkPipelineColorBlendAttachmentState> blends(formats.size(), opaque);
    const VkPipelineColorBlendStateCreateInfo blend{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_COLOR_BLEND_STATE_CREATE_INFO,
        .attachmentCount = static_cast<std::uint32_t>(blends.size()),
        .pAttachments = blends.data()};
    const std::array dynamic_states{VK_DYNAMIC_STATE_VIEWPORT, VK_DYNAMIC_STATE_SCISSOR};
    const VkPipelineDynamicStateCreateInfo dynamic{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_DYNAMIC_STATE_CREATE_INFO,
        .dynamicStateCount = dynamic_states.size(),
        .pDynamicStates = dynamic_states.data()};
    const VkPipelineRenderingCreateInfo rendering{
        .sType = VK_STRUCTURE_TYPE_PIPELINE_RENDERING_CREATE_INFO,
        .colorAttachmentCount = static_cast<std::uint32_t>(formats.size()),
        .pColorAttachmentFormats = formats.data(),
        .depthAttachmentFormat = kDepthFormat};
    const VkGraphicsPipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_GRAPHICS_PIPELINE_CREATE_INFO,
                                            .pNext = &rendering,
                                            .stageCount = stages.size(),
                                            .pStages = stages.data(),
                                            .pVertexInputState = &input,
                                            .pInputAssemblyState = &assembly,
                                            .pViewportState = &viewport,
                                            .pRasterizationState = &raster,
                                            .pMultisampleState = &samples,
                                            .pDepthStencilState = &depth,
                                            .pColorBlendState = &blend,
                                            .pDynamicState = &dynamic,
                                            .layout = layout_.get()};
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateGraphicsPipelines(device_.get(), cache_.get(), 1, &info, nullptr, &pipeline),
          "building a pipeline");
    return {device_.get(), pipeline};
}

Pipeline Pipelines::make_probe() const {
    const ShaderModule module = make_shader(device_.get(), kProbe);
    const VkComputePipelineCreateInfo info{.sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
                                           .stage = stage(VK_SHADER_STAGE_COMPUTE_BIT, module),
                                           .layout = layout_.get()};
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device_.get(), cache_.get(), 1, &info, nullptr, &pipeline),
          "building a pipeline");
    return {device_.get(), pipeline};
}

}  // namespace carat::vk
