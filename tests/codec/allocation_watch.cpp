#include "allocation_watch.hpp"

#include <atomic>
#include <cstdlib>
#include <new>

namespace {

std::atomic<std::size_t> largest{0}, number{0};

void* watched(std::size_t size) {
    ++number;
    std::size_t seen = largest;
    while (seen < size && !largest.compare_exchange_weak(seen, size)) {
    }
    if (void* p = std::malloc(size > 0 ? size : 1)) return p;
    throw std::bad_alloc();
}

}  // namespace

void* operator new(std::size_t size) { return watched(size); }
void* operator new[](std::size_t size) { return watched(size); }
void operator delete(void* p) noexcept { std::free(p); }
void operator delete[](void* p) noexcept { std::free(p); }
void operator delete(void* p, std::size_t) noexcept { std::free(p); }
void operator delete[](void* p, std::size_t) noexcept { std::free(p); }

namespace carat::test {

std::size_t largest_allocation() { return largest; }
std::size_t allocations() { return number; }
void forget_allocations() {
    largest = 0;
    number = 0;
}

}  // namespace carat::test
