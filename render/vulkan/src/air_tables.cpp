#include "air_tables.hpp"

#include "pipelines.hpp"
#include "table_texture.hpp"

namespace carat::vk {

namespace {

Image make_table(const Device& device, std::uint32_t width, std::uint32_t height) {
    return make_image(
        device, {{width, height},
                 VK_FORMAT_R16G16B16A16_SFLOAT,
                 VK_IMAGE_USAGE_SAMPLED_BIT | VK_IMAGE_USAGE_STORAGE_BIT | VK_IMAGE_USAGE_TRANSFER_DST_BIT,
                 VK_SAMPLE_COUNT_1_BIT,
                 1,
                 "tables of the sky"});
}

SetLayout make_air_set(VkDevice device) {
    constexpr VkShaderStageFlags kCompute = VK_SHADER_STAGE_COMPUTE_BIT;
    const std::array bindings{
        one_binding(gpu::kBindTransmittance, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kCompute),
        one_binding(gpu::kBindMultiple, VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, kCompute),
        one_binding(gpu::kBindAirOut, VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, kCompute)};
    return make_set_layout(device, bindings);
}

DescriptorPool make_pool(VkDevice device) {
    const std::array sizes{VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, 6},
                           VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, 3}};
    const VkDescriptorPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                          .maxSets = 3,
                                          .poolSizeCount = sizes.size(),
                                          .pPoolSizes = sizes.data()};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device, &info, nullptr, &pool), "creating a descriptor pool");
    return {device, pool};
}

Pipeline make_pipeline(VkDevice device, VkPipelineLayout layout, VkShaderModule module, std::uint32_t table) {
    const VkSpecializationMapEntry entry{.constantID = 0, .offset = 0, .size = sizeof(table)};
    const VkSpecializationInfo constants{
        .mapEntryCount = 1, .pMapEntries = &entry, .dataSize = sizeof(table), .pData = &table};
    const VkComputePipelineCreateInfo info{
        .sType = VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO,
        .stage = {.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO,
                  .stage = VK_SHADER_STAGE_COMPUTE_BIT,
                  .module = module,
                  .pName = "main",
                  .pSpecializationInfo = &constants},
        .layout = layout};
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "building a pipeline");
    return {device, pipeline};
}

VkDescriptorSet allocate_set(VkDevice device, VkDescriptorPool pool, VkDescriptorSetLayout layout) {
    const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = pool,
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &layout};
    VkDescriptorSet set = VK_NULL_HANDLE;
    check(vkAllocateDescriptorSets(device, &info, &set), "allocating a descriptor set");
    return set;
}

std::uint32_t groups(std::uint32_t texels) { return (texels + gpu::kAirGroup - 1) / gpu::kAirGroup; }

}  // namespace

// In the order in which they need each other.
AirTables::AirTables(Device& device)
    : device_(device),
      tables_{{{gpu::kBindTransmittance,
                make_table(device, gpu::kTransmittanceCosines, gpu::kTransmittanceHeights)},
               {gpu::kBindMultiple, make_table(device, gpu::kMultipleCosines, gpu::kMultipleHeights)},
               {gpu::kBindSkyLight, make_table(device, gpu::kSkyLightCosines, gpu::kSkyLightHeights)}}} {
    const VkCommandBuffer commands = device_.new_commands();
    device_.begin(commands);
    for (const Table& table : tables_) {
        change_layout(commands, table.image, VK_IMAGE_LAYOUT_UNDEFINED, VK_IMAGE_LAYOUT_GENERAL);
        const VkClearColorValue zero{};
        const VkImageSubresourceRange whole{VK_IMAGE_ASPECT_COLOR_BIT, 0, 1, 0, 1};
        vkCmdClearColorImage(commands, table.image.handle.get(), VK_IMAGE_LAYOUT_GENERAL, &zero, 1, &whole);
    }
    full_barrier(commands);
    device_.wait(device_.submit(commands));
    device_.free_commands(commands);
}

std::array<AirTables::View, 3> AirTables::views() const {
    std::array<View, 3> out{};
    for (std::size_t k = 0; k < out.size(); ++k) out[k] = {tables_[k].binding, tables_[k].image.view.get()};
    return out;
}

void AirTables::write_set(VkDescriptorSet set, const Table& out, VkSampler sampler) const {
    const std::array images{
        VkDescriptorImageInfo{sampler, tables_[0].image.view.get(), VK_IMAGE_LAYOUT_GENERAL},
        VkDescriptorImageInfo{sampler, tables_[1].image.view.get(), VK_IMAGE_LAYOUT_GENERAL},
        VkDescriptorImageInfo{VK_NULL_HANDLE, out.image.view.get(), VK_IMAGE_LAYOUT_GENERAL}};
    const std::array bindings{gpu::kBindTransmittance, gpu::kBindMultiple, gpu::kBindAirOut};
    std::array<VkWriteDescriptorSet, 3> writes{};
    for (std::size_t k = 0; k < writes.size(); ++k)
        writes[k] = {.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                     .dstSet = set,
                     .dstBinding = bindings[k],
                     .descriptorCount = 1,
                     .descriptorType = k == 2 ? VK_DESCRIPTOR_TYPE_STORAGE_IMAGE
                                              : VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                     .pImageInfo = &images[k]};
    vkUpdateDescriptorSets(device_.get(), writes.size(), writes.data(), 0, nullptr);
}

void AirTables::make(const gpu::AirData& air) {
    const SetLayout set_layout = make_air_set(device_.get());
    const PipelineLayout layout = make_layout(device_.get(), set_layout.get(), sizeof(gpu::AirData));
    const DescriptorPool pool = make_pool(device_.get());
    const Sampler sampler = make_table_sampler(device_);
    const ShaderModule module = make_shader(device_.get(), kAirTables);
    std::array<Pipeline, 3> pipelines;
    const VkCommandBuffer commands = device_.new_commands();
    device_.begin(commands);
    for (std::size_t k = 0; k < tables_.size(); ++k) {
        const Table& table = tables_[k];
        pipelines[k] = make_pipeline(device_.get(), layout.get(), module.get(), table.binding);
        const VkDescriptorSet set = allocate_set(device_.get(), pool.get(), set_layout.get());
        write_set(set, table, sampler.get());
        vkCmdBindPipeline(commands, VK_PIPELINE_BIND_POINT_COMPUTE, pipelines[k].get());
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_COMPUTE, layout.get(), 0, 1, &set, 0,
                                nullptr);
        vkCmdPushConstants(commands, layout.get(), VK_SHADER_STAGE_COMPUTE_BIT, 0, sizeof(air), &air);
        vkCmdDispatch(commands, groups(table.image.extent.width), groups(table.image.extent.height), 1);
        full_barrier(commands);
    }
    device_.wait(device_.submit(commands));
    device_.free_commands(commands);
}

}  // namespace carat::vk
