#include "carat/render/block_allocator.hpp"

#include <mutex>
#include <unordered_map>
#include <vector>

namespace carat {
namespace {

constexpr std::size_t kLeast = 4096, kGreatestKept = std::size_t{64} << 20;

struct Shelf {
    std::mutex mutex;
    std::unordered_map<std::size_t, std::vector<void*>> blocks;
    std::size_t kept = 0;
};

// A thread that finds it taken does without: nobody waits for a thread that was put aside while it had it.
using TryLock = std::unique_lock<std::mutex>;

// Never destroyed: meshes may outlive everything.
Shelf& shelf() {
    static Shelf& shelf = *new Shelf;
    return shelf;
}

}  // namespace

void* take_block(std::size_t bytes) {
    if (bytes >= kLeast) {
        Shelf& s = shelf();
        const TryLock lock(s.mutex, std::try_to_lock);
        const auto it = lock ? s.blocks.find(bytes) : s.blocks.end();
        if (it != s.blocks.end() && !it->second.empty()) {
            void* const block = it->second.back();
            it->second.pop_back();
            s.kept -= bytes;
            return block;
        }
    }
    return ::operator new (bytes, std::align_val_t{64});
}

void give_block(void* block, std::size_t bytes) noexcept {
    if (bytes >= kLeast) {
        Shelf& s = shelf();
        const TryLock lock(s.mutex, std::try_to_lock);
        if (lock && s.kept + bytes <= kGreatestKept) {
            try {
                s.blocks[bytes].push_back(block);
                s.kept += bytes;
                return;
            } catch (const std::bad_alloc&) {
            }
        }
    }
    ::operator delete (block, std::align_val_t{64});
}

}  // namespace carat
