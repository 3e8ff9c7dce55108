// What the system says of a thread.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "thread_usage.hpp"

namespace carat::bench {
namespace {

TEST(ThreadUsage, TellsWorkFromSleep) {
    const ThreadUsage start = ThreadUsage::now();
    while ((ThreadUsage::now() - start).cpu_ms < 5) {
    }
    const ThreadUsage worked = ThreadUsage::now();
    constexpr int kSleeps = 5;
    for (int k = 0; k < kSleeps; ++k) std::this_thread::sleep_for(std::chrono::milliseconds(3));
    const ThreadUsage slept = ThreadUsage::now() - worked;
    EXPECT_LT(slept.cpu_ms, 5) << "of 15 ms of sleep";
    EXPECT_GE(slept.ready_ms, 0);
    EXPECT_GE((worked - start).ready_ms, 0);
#ifdef __linux__
    EXPECT_GE(slept.slept, kSleeps);
#endif
}

// As each thread sees itself.
TEST(ThreadUsage, IsOfTheCallingThread) {
    const ThreadUsage before = ThreadUsage::now();
    double other = 0;
    std::thread([&other] {
        const ThreadUsage start = ThreadUsage::now();
        do other = (ThreadUsage::now() - start).cpu_ms;
        while (other < 20);
    }).join();
    EXPECT_GE(other, 20);
    EXPECT_LT((ThreadUsage::now() - before).cpu_ms, 10);
}

}  // namespace
}  // namespace carat::bench
