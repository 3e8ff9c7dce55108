// Memory for the big arrays that come and go all the time: meshes and heights.
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <type_traits>
#include <utility>

namespace carat {

// Blocks of at least 4 KiB are kept for the next one of the same size (up to 64 MiB in all) instead of going
// back to the system, which would have to clear them again. Thread-safe.
void* take_block(std::size_t bytes);  // throws std::bad_alloc
void give_block(void* block, std::size_t bytes) noexcept;

// Leaves trivial elements uninitialised where a container asks for default ones.
template <class T>
class BlockAllocator {
  public:
    using value_type = T;
    BlockAllocator() = default;
    template <class U>
    BlockAllocator(const BlockAllocator<U>&) {}

    T* allocate(std::size_t count) { return static_cast<T*>(take_block(count * sizeof(T))); }
    void deallocate(T* p, std::size_t count) noexcept { give_block(p, count * sizeof(T)); }
    template <class U>
    void construct(U* p) noexcept(std::is_nothrow_default_constructible_v<U>) {
        ::new (static_cast<void*>(p)) U;
    }
    template <class U, class... Arguments>
    void construct(U* p, Arguments&&... arguments) {
        ::new (static_cast<void*>(p)) U(std::forward<Arguments>(arguments)...);
    }
    friend bool operator==(const BlockAllocator&, const BlockAllocator&) { return true; }
};

}  // namespace carat
