#include "patch_store.hpp"

#include <algorithm>
#include <array>

#include "carat/globe/patch.hpp"
#include "shared.h"
#include "triangle_order.hpp"

namespace carat::vk {

namespace {

constexpr std::size_t kChunkBytes = std::size_t{256} << 20;

static_assert(sizeof(gpu::VertexData) == sizeof(PatchVertex));
static_assert(offsetof(gpu::VertexData, normal) == offsetof(PatchVertex, normal));
static_assert(offsetof(gpu::VertexData, height) == offsetof(PatchVertex, height));

std::uint32_t slots_per_chunk(const Device& device, std::size_t patch_bytes, std::uint32_t capacity) {
    const std::size_t bytes =
        std::min({kChunkBytes, std::size_t{device.properties().limits.maxStorageBufferRange},
                  static_cast<std::size_t>(device.max_allocation())});
    const std::size_t slots = std::min<std::size_t>(
        {bytes / patch_bytes, capacity, device.properties().limits.maxDrawIndirectCount});
    return static_cast<std::uint32_t>(std::max<std::size_t>(slots, 1));
}

DescriptorPool make_pool(VkDevice device, std::uint32_t sets) {
    const std::array sizes{VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_STORAGE_BUFFER, sets * 5},
                           VkDescriptorPoolSize{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER, sets * 4}};
    const VkDescriptorPoolCreateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_POOL_CREATE_INFO,
                                          .maxSets = sets,
                                          .poolSizeCount = sizes.size(),
                                          .pPoolSizes = sizes.data()};
    VkDescriptorPool pool = VK_NULL_HANDLE;
    check(vkCreateDescriptorPool(device, &info, nullptr, &pool), "creating a descriptor pool");
    return {device, pool};
}

}  // namespace

PatchStore::PatchStore(Device& device, UploadRing& ring, VkDescriptorSetLayout layout, int cells,
                       int capacity, bool coloured)
    : device_(device),
      ring_(ring),
      layout_(layout),
      cells_(cells),
      vertex_count_(half_vertex_count(cells)),
      capacity_(static_cast<std::uint32_t>(capacity)),
      chunk_slots_(slots_per_chunk(device, vertex_count_ * sizeof(PatchVertex), capacity_)),
      coloured_(coloured),
      slots_(capacity_),
      pool_(make_pool(device.get(), (capacity_ + chunk_slots_ - 1) / chunk_slots_)) {
    make_indices();
}

void PatchStore::make_indices() {
    const auto indices = drawn_indices(cells_);
    const std::size_t bytes = indices.size() * sizeof(indices[0]);
    indices_ =
        make_buffer(device_, bytes, VK_BUFFER_USAGE_INDEX_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT,
                    Where::device, "indices");
    ring_.copy(indices_.handle.get(), 0, indices.data(), bytes);
}

void PatchStore::bind_shared(const SharedBindings& shared) {
    shared_ = shared;
    for (const Chunk& chunk : chunks_) write_set(chunk.set, chunk);
}

void PatchStore::write_set(VkDescriptorSet set, const Chunk& chunk) const {
    const auto whole = [](VkBuffer buffer) { return VkDescriptorBufferInfo{buffer, 0, VK_WHOLE_SIZE}; };
    // Without colours something must be bound all the same; nothing reads it.
    const Buffer& colours = coloured_ ? chunk.colours : chunk.vertices;
    const std::array buffers{whole(shared_.frame), whole(chunk.vertices.handle.get()),
                             whole(chunk.patches.handle.get()), whole(shared_.probe),
                             whole(colours.handle.get())};
    const std::array bindings{gpu::kBindFrame, gpu::kBindVertices, gpu::kBindPatches, gpu::kBindProbe,
                              gpu::kBindColours};
    std::array<VkDescriptorImageInfo, 4> images{
        {{shared_.sampler, shared_.table, VK_IMAGE_LAYOUT_SHADER_READ_ONLY_OPTIMAL}}};
    std::array<std::uint32_t, 4> image_bindings{gpu::kBindTable};
    for (std::size_t k = 0; k < shared_.air.size(); ++k) {
        images[k + 1] = {shared_.sampler, shared_.air[k].view, VK_IMAGE_LAYOUT_GENERAL};
        image_bindings[k + 1] = shared_.air[k].binding;
    }
    std::vector<VkWriteDescriptorSet> writes;
    for (std::size_t i = 0; i < buffers.size(); ++i)
        writes.push_back({.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                          .dstSet = set,
                          .dstBinding = bindings[i],
                          .descriptorCount = 1,
                          .descriptorType = VK_DESCRIPTOR_TYPE_STORAGE_BUFFER,
                          .pBufferInfo = &buffers[i]});
    for (std::size_t i = 0; i < images.size(); ++i)
        writes.push_back({.sType = VK_STRUCTURE_TYPE_WRITE_DESCRIPTOR_SET,
                          .dstSet = set,
                          .dstBinding = image_bindings[i],
                          .descriptorCount = 1,
                          .descriptorType = VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                          .pImageInfo = &images[i]});
    vkUpdateDescriptorSets(device_.get(), static_cast<std::uint32_t>(writes.size()), writes.data(), 0,
                           nullptr);
}

void PatchStore::add_chunk() {
    const auto first = static_cast<std::uint32_t>(chunks_.size()) * chunk_slots_;
    const std::size_t slots = std::min(chunk_slots_, capacity_ - first);
    const VkBufferUsageFlags storage = VK_BUFFER_USAGE_STORAGE_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    const VkBufferUsageFlags indirect =
        VK_BUFFER_USAGE_INDIRECT_BUFFER_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT;
    Chunk chunk;
    chunk.vertices =
        make_buffer(device_, slots * vertex_count_ * sizeof(PatchVertex), storage, Where::device, "patches");
    chunk.patches =
        make_buffer(device_, slots * sizeof(gpu::PatchData), storage, Where::device, "patch anchors");
    chunk.draws = make_buffer(device_, slots * sizeof(VkDrawIndexedIndirectCommand), indirect, Where::device,
                              "draw commands");
    if (coloured_)
        chunk.colours = make_buffer(device_, slots * vertex_count_ * sizeof(std::uint32_t), storage,
                                    Where::device, "colours of patches");
    const VkDescriptorSetAllocateInfo info{.sType = VK_STRUCTURE_TYPE_DESCRIPTOR_SET_ALLOCATE_INFO,
                                           .descriptorPool = pool_.get(),
                                           .descriptorSetCount = 1,
                                           .pSetLayouts = &layout_};
    check(vkAllocateDescriptorSets(device_.get(), &info, &chunk.set), "allocating a descriptor set");
    write_set(chunk.set, chunk);
    chunks_.push_back(std::move(chunk));
}

// Takes memory for the slot's chunk. When the device has no more, the slots there are must do: batches get
// smaller.
bool PatchStore::make_room(std::uint32_t slot) {
    try {
        while (slot / chunk_slots_ >= chunks_.size()) add_chunk();
        return true;
    } catch (const Error& error) {
        slots_.shrink(static_cast<std::uint32_t>(chunks_.size()) * chunk_slots_);
        if (error.code() != ErrorCode::limit || chunks_.empty()) throw;
        return false;
    }
}

void PatchStore::begin_batch() {
    slots_.begin_batch();
    for (Chunk& chunk : chunks_) chunk.commands.clear();
}

bool PatchStore::add(const MeshPointer& mesh) {
    if (mesh->vertices.size() != vertex_count_) {
        throw Error(ErrorCode::usage, "patch " + to_string(mesh->half.diamond) + " has " +
                                          std::to_string(mesh->vertices.size()) + " vertices instead of " +
                                          std::to_string(vertex_count_));
    }
    if (coloured_ && mesh->colours.size() != vertex_count_)
        throw Error(ErrorCode::usage, "patch " + to_string(mesh->half.diamond) + " has no colours");
    const auto place = slots_.acquire(mesh);
    if (!place) return false;
    last_slot_ = place->slot;
    if (!make_room(place->slot)) return false;
    Chunk& chunk = chunks_[place->slot / chunk_slots_];
    const std::uint32_t slot = place->slot % chunk_slots_;
    if (place->fresh) upload(*mesh, chunk, slot);
    const auto index_count = static_cast<std::uint32_t>(3 * cells_ * cells_);
    chunk.commands.push_back({.indexCount = index_count,
                              .instanceCount = 1,
                              .firstIndex = static_cast<std::uint32_t>(mesh->half.side) * index_count,
                              .vertexOffset = static_cast<std::int32_t>(slot * vertex_count_),
                              .firstInstance = slot});
    return true;
}

void PatchStore::upload(const PatchMesh& mesh, Chunk& chunk, std::uint32_t slot) {
    const std::size_t bytes = vertex_count_ * sizeof(PatchVertex);
    const std::uint64_t id = mesh.half.diamond.bits() * 2 + static_cast<std::uint64_t>(mesh.half.side);
    const gpu::PatchData data{mesh.anchor[0], mesh.anchor[1], mesh.anchor[2], static_cast<std::uint32_t>(id),
                              static_cast<std::uint32_t>(id >> 32)};
    ring_.copy(chunk.vertices.handle.get(), slot * bytes, mesh.vertices.data(), bytes);
    ring_.copy(chunk.patches.handle.get(), slot * sizeof(data), &data, sizeof(data));
    if (coloured_) {
        const std::size_t size = vertex_count_ * sizeof(std::uint32_t);
        ring_.copy(chunk.colours.handle.get(), slot * size, mesh.colours.data(), size);
    }
    ++uploads_;
    upload_bytes_ += patch_bytes();
}

std::size_t PatchStore::patch_bytes() const {
    return vertex_count_ * (sizeof(PatchVertex) + (coloured_ ? sizeof(std::uint32_t) : 0)) +
           sizeof(gpu::PatchData);
}

void PatchStore::end_batch() {
    for (const Chunk& chunk : chunks_) {
        const std::size_t bytes = chunk.commands.size() * sizeof(chunk.commands[0]);
        if (bytes > 0) ring_.copy(chunk.draws.handle.get(), 0, chunk.commands.data(), bytes);
    }
}

int PatchStore::draw(VkCommandBuffer commands, VkPipelineLayout layout) const {
    int calls = 0;
    vkCmdBindIndexBuffer(commands, indices_.handle.get(), 0, VK_INDEX_TYPE_UINT16);
    for (const Chunk& chunk : chunks_) {
        if (chunk.commands.empty()) continue;
        vkCmdBindDescriptorSets(commands, VK_PIPELINE_BIND_POINT_GRAPHICS, layout, 0, 1, &chunk.set, 0,
                                nullptr);
        vkCmdDrawIndexedIndirect(commands, chunk.draws.handle.get(), 0,
                                 static_cast<std::uint32_t>(chunk.commands.size()),
                                 sizeof(VkDrawIndexedIndirectCommand));
        ++calls;
    }
    return calls;
}

VkDescriptorSet PatchStore::shared_set() {
    if (chunks_.empty()) add_chunk();
    return chunks_.front().set;
}

std::pair<VkDescriptorSet, std::uint32_t> PatchStore::last_added() const {
    return {chunks_[last_slot_ / chunk_slots_].set, last_slot_ % chunk_slots_};
}

}  // namespace carat::vk
