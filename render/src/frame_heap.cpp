#include "frame_heap.hpp"

#include <algorithm>
#include <bit>
#include <cassert>
#include <new>
#include <utility>

namespace carat {
namespace {

constexpr std::size_t kAlignment = 64;

}  // namespace

FrameHeap::FrameHeap() : owner_(std::this_thread::get_id()) { (void)carve(0); }

void* FrameHeap::do_allocate(std::size_t bytes, std::size_t alignment) {
    assert(owner_.load(std::memory_order_relaxed) == std::this_thread::get_id());
    if (bytes > kGreatest || alignment > kAlignment)
        return ::operator new (bytes, std::align_val_t{std::max(alignment, kAlignment)});
    const std::size_t size = std::bit_ceil(std::max({bytes, alignment, std::size_t{1} << kLeastLog2}));
    const auto shelf = static_cast<std::size_t>(std::countr_zero(size) - kLeastLog2);
    if (shelves_[shelf] == nullptr) take_returned();
    if (Free* const block = shelves_[shelf]; block != nullptr) {
        shelves_[shelf] = block->next;
        return block;
    }
    return carve(size);
}

void FrameHeap::do_deallocate(void* block, std::size_t bytes, std::size_t alignment) {
    if (bytes > kGreatest || alignment > kAlignment)
        return ::operator delete (block, std::align_val_t{std::max(alignment, kAlignment)});
    const std::size_t size = std::bit_ceil(std::max({bytes, alignment, std::size_t{1} << kLeastLog2}));
    const auto shelf = static_cast<std::size_t>(std::countr_zero(size) - kLeastLog2);
    if (owner_.load(std::memory_order_relaxed) == std::this_thread::get_id()) {
        shelves_[shelf] = ::new (block) Free{shelves_[shelf], shelf};
        return;
    }
    Free* const free = ::new (block) Free{returned_.load(std::memory_order_relaxed), shelf};
    while (!returned_.compare_exchange_weak(free->next, free, std::memory_order_release,
                                            std::memory_order_relaxed)) {
    }
}

void FrameHeap::take_returned() {
    for (Free* f = returned_.exchange(nullptr, std::memory_order_acquire); f != nullptr;) {
        Free* const next = f->next;
        f->next = std::exchange(shelves_[f->shelf], f);
        f = next;
    }
}

void* FrameHeap::carve(std::size_t bytes) {
    const std::size_t step = std::max(bytes, kAlignment);  // so that every block is aligned
    if (left_ < step) add_chunk(kChunk);
    left_ -= step;
    return std::exchange(room_, room_ + step);
}

// Filled, for a page that has not been touched may have to wait for whoever maps memory. What is left of the
// last chunk is lost.
void FrameHeap::add_chunk(std::size_t bytes) {
    left_ = bytes + kAlignment;
    chunks_.push_back(std::make_unique<std::byte[]>(left_));
    void* start = chunks_.back().get();
    room_ = static_cast<std::byte*>(std::align(kAlignment, bytes, start, left_));
}

}  // namespace carat
