// A frame with a time limit asks the system for no memory: whoever does may wait for a thread that the system
// has put aside.
#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "carat/render/refiner.hpp"
#include "render/cut/support.hpp"

namespace {

thread_local bool counting = false;
thread_local std::uint64_t requests = 0;

void* take(std::size_t bytes, std::size_t alignment) {
    if (counting) ++requests;
    void* const block = std::aligned_alloc(alignment, (bytes + alignment - 1) / alignment * alignment);
    if (block == nullptr) throw std::bad_alloc();
    return block;
}
void give(void* block) noexcept {
    if (counting && block != nullptr) ++requests;
    std::free(block);
}

}  // namespace

// Of this program: all of C++'s come here.
void* operator new(std::size_t bytes) { return take(bytes, 16); }
void* operator new(std::size_t bytes, std::align_val_t alignment) {
    return take(bytes, static_cast<std::size_t>(alignment));
}
void operator delete(void* block) noexcept { give(block); }
void operator delete(void* block, std::size_t) noexcept { give(block); }
void operator delete(void* block, std::align_val_t) noexcept { give(block); }
void operator delete(void* block, std::size_t, std::align_val_t) noexcept { give(block); }

namespace carat::test {
namespace {

std::uint64_t requests_of(Refiner& refiner, const View& view, double milliseconds, RefinedFrame& frame) {
    RefineBudget budget;
    budget.milliseconds = milliseconds;
    requests = 0;
    counting = true;
    refiner.frame(view, {1, 0}, budget, frame);
    counting = false;
    return requests;
}

// Jumps between views that each converge or are cut short: everything that frames do.
TEST(FrameAllocation, AFrameWithATimeLimitAsksForNone) {
    const FakeRepository& planet = rough_earth();
    RefinerOptions options;
    options.bytes = 3'000'000;  // little, so that refinements come and go
    Refiner refiner({std::shared_ptr<const void>(), &planet}, options);
    const auto views = test_views(planet, 12, 5);
    RefinedFrame frame;
    frame.draw.reserve(10'000);
    frame.upload.reserve(10'000);
    std::uint64_t installed = 0, coarsened = 0, uploads = 0;
    for (int round = 0; round < 2; ++round)
        for (const NamedView& v : views)
            for (const double ms : {0.3, 2.0, 2.0, 2.0}) {
                const std::uint64_t count = requests_of(refiner, v.view, ms, frame);
                EXPECT_EQ(count, 0u) << v.name << ", " << ms << " ms";
                installed += frame.counters.installed;
                coarsened += frame.counters.coarsened;
                uploads += frame.counters.uploads;
            }
    EXPECT_GT(installed, 50u);
    EXPECT_GT(coarsened, 50u);
    EXPECT_GT(uploads, 100u);
}

}  // namespace
}  // namespace carat::test
