// Patches in device memory: chunks of fixed slots, one shared index buffer, one indirect multi-draw a chunk.
#pragma once

#include <deque>

#include "air_tables.hpp"
#include "pipelines.hpp"
#include "slot_cache.hpp"
#include "upload_ring.hpp"

namespace carat::vk {

// Buffers and the texture that every chunk's descriptor set shares.
struct SharedBindings {
    VkBuffer frame = VK_NULL_HANDLE, probe = VK_NULL_HANDLE;
    VkImageView table = VK_NULL_HANDLE;
    VkSampler sampler = VK_NULL_HANDLE;
    std::array<AirTables::View, 3> air{};
};

class PatchStore {
  public:
    // coloured: meshes bring colours, which are uploaded with them.
    PatchStore(Device& device, UploadRing& ring, VkDescriptorSetLayout layout, int cells, int capacity,
               bool coloured);

    // Writes the shared bindings into every descriptor set, now and for chunks to come. The device must be
    // idle.
    void bind_shared(const SharedBindings& shared);

    void begin_batch();
    bool resident(const MeshPointer& mesh) const { return slots_.resident(mesh); }
    // Queues the mesh for drawing, uploading it when it is not resident; false if this batch has no slot
    // left.
    bool add(const MeshPointer& mesh);
    // Uploads the draw commands of the batch. The ring must be flushed before draw().
    void end_batch();
    // Returns how many multi-draws that took: one for each chunk with patches of the batch.
    int draw(VkCommandBuffer commands, VkPipelineLayout layout) const;

    // The descriptor set and the slot within it that hold a mesh added in this batch last.
    std::pair<VkDescriptorSet, std::uint32_t> last_added() const;

    // A set with the shared bindings, whether or not there are patches.
    VkDescriptorSet shared_set();

    // What uploading one patch costs.
    std::size_t patch_bytes() const;
    std::uint64_t uploads() const { return uploads_; }
    std::uint64_t upload_bytes() const { return upload_bytes_; }

  private:
    struct Chunk {
        Buffer vertices, patches, draws, colours;
        VkDescriptorSet set = VK_NULL_HANDLE;
        std::vector<VkDrawIndexedIndirectCommand> commands;
    };
    void make_indices();
    void add_chunk();
    bool make_room(std::uint32_t slot);
    void write_set(VkDescriptorSet set, const Chunk& chunk) const;
    void upload(const PatchMesh& mesh, Chunk& chunk, std::uint32_t slot);

    Device& device_;
    UploadRing& ring_;
    VkDescriptorSetLayout layout_;
    int cells_;
    std::uint32_t vertex_count_, capacity_, chunk_slots_;
    bool coloured_;
    SlotCache slots_;
    SharedBindings shared_;
    Buffer indices_;
    DescriptorPool pool_;
    std::deque<Chunk> chunks_;
    std::uint32_t last_slot_ = 0;
    std::uint64_t uploads_ = 0, upload_bytes_ = 0;
};

}  // namespace carat::vk
