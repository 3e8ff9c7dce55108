// Workers that never keep their owner waiting: order, names, drops, errors and waste.
#include <gtest/gtest.h>

#include <set>
#include <stdexcept>

#include "worker_pool.hpp"

namespace carat {
namespace {

using Task = std::function<int()>;
using Clock = WorkerPool<Task, int>::Clock;
constexpr auto kNever = Clock::time_point::max();

struct OwnHeap {
    FrameHeap heap;
};
class Pool : OwnHeap, WorkerPool<Task, int> {
    using Base = WorkerPool<Task, int>;

  public:
    using Base::Done, Base::Job, Base::discard, Base::drop_unstarted, Base::empty_waste;
    explicit Pool(int threads)
        : Base(
              threads, [] {}, [](Task& task) { return task(); }, heap) {}

    void add(const std::vector<Job>& jobs) {
        Jobs added(jobs.begin(), jobs.end(), &heap);
        Base::add(added);
        EXPECT_TRUE(added.empty());
    }
    std::vector<Done> take() {
        std::vector<Done> out;
        Base::take([&](Done& d) { out.push_back(std::move(d)); });
        return out;
    }
    std::vector<Done> take(Clock::time_point deadline) {
        Base::wait(deadline);
        return take();
    }
};

// Holds up whoever runs into it until it is opened.
class Gate {
  public:
    void pass() {
        arrived_.post();
        open_.wait();
    }
    void wait_for_one() { arrived_.wait(); }
    void open(int times = 1) {
        for (int k = 0; k < times; ++k) open_.post();
    }

  private:
    Semaphore arrived_, open_;
};

Pool::Job job(double priority, std::uint64_t key, Task run) { return {priority, key, std::move(run)}; }

std::vector<Pool::Done> take_all(Pool& pool, std::size_t count) {
    std::vector<Pool::Done> out;
    while (out.size() < count)
        for (Pool::Done& d : pool.take(kNever)) out.push_back(std::move(d));
    return out;
}

TEST(WorkerPool, TheMostUrgentJobComesFirst) {
    Pool pool(1);
    Gate gate;
    pool.add({job(0, 100, [&] {
        gate.pass();
        return 0;
    })});
    gate.wait_for_one();
    pool.add({job(1, 1, [] { return 1; }), job(3, 3, [] { return 3; })});
    pool.add({job(2, 2, [] { return 2; })});
    gate.open();
    std::vector<int> order;
    for (const Pool::Done& d : take_all(pool, 4)) order.push_back(d.result);
    EXPECT_EQ(order, (std::vector<int>{0, 3, 2, 1}));
}

TEST(WorkerPool, AJobIsNotStartedAgainBeforeItsResultIsTaken) {
    Pool pool(2);
    std::atomic<int> runs{0};
    const auto count = [&] { return ++runs; };
    pool.add({job(1, 7, count), job(1, 7, count), job(1, 7, count)});
    EXPECT_EQ(take_all(pool, 1).size(), 1u);
    EXPECT_TRUE(pool.take(kNever).empty()) << "nothing in hand: no wait";
    EXPECT_EQ(runs, 1);
    pool.add({job(1, 7, count)});
    EXPECT_EQ(take_all(pool, 1)[0].key, 7u) << "it may be asked for again then";
    EXPECT_EQ(runs, 2);
}

// Asked for again while its result was under way: the result is the answer to both.
TEST(WorkerPool, AResultAnswersWhatWasAskedBeforeItWasTaken) {
    Pool pool(1);
    Gate first, second;
    std::atomic<int> runs{0};
    pool.add({job(1, 7, [&] {
        first.pass();
        return ++runs;
    })});
    first.wait_for_one();
    pool.add({job(9, 8, [&] {
        second.pass();
        return 0;
    })});
    first.open();
    second.wait_for_one();  // 7 is done and not taken, the worker held up
    pool.drop_unstarted();
    pool.add({job(1, 7, [&] { return ++runs; })});
    EXPECT_EQ(take_all(pool, 1)[0].key, 7u);
    pool.add({job(1, 9, [] { return 0; })});
    second.open();
    (void)take_all(pool, 2);
    EXPECT_TRUE(pool.take(kNever).empty());
    EXPECT_EQ(runs, 1);
}

TEST(WorkerPool, WhatWasDroppedIsNotRun) {
    Pool pool(1);
    Gate gate;
    std::atomic<bool> ran{false};
    const auto held = std::make_shared<int>(0);
    pool.add({job(9, 1, [&] {
        gate.pass();
        return 1;
    })});
    gate.wait_for_one();
    pool.add({job(5, 2, [&ran, held] {
        ran = true;
        return 2;
    })});
    pool.drop_unstarted();
    pool.add({job(4, 3, [] { return 3; })});
    gate.open();
    std::set<int> results;
    for (const Pool::Done& d : take_all(pool, 2)) results.insert(d.result);
    EXPECT_EQ(results, (std::set<int>{1, 3}));
    EXPECT_TRUE(pool.take(kNever).empty());
    EXPECT_FALSE(ran);
}

TEST(WorkerPool, AnErrorIsAResult) {
    Pool pool(1);
    pool.add({job(1, 1, []() -> int { throw std::runtime_error("no"); })});
    const auto done = take_all(pool, 1);
    EXPECT_THROW(std::rethrow_exception(done[0].error), std::runtime_error);
}

TEST(WorkerPool, ADeadlineEndsTheWait) {
    Pool pool(1);
    Gate gate;
    pool.add({job(1, 1, [&] {
        gate.pass();
        return 1;
    })});
    gate.wait_for_one();
    const auto deadline = Clock::now() + std::chrono::milliseconds(5);
    EXPECT_TRUE(pool.take(deadline).empty());
    EXPECT_GE(Clock::now(), deadline);
    EXPECT_TRUE(pool.take(Clock::time_point::min()).empty());
    gate.open();
    EXPECT_EQ(take_all(pool, 1)[0].result, 1);
}

// Says which thread destroyed it.
class Tells {
  public:
    Tells(std::thread::id& by, Semaphore& gone) : by_(by), gone_(gone) {}
    Tells(const Tells&) = delete;
    ~Tells() {
        by_ = std::this_thread::get_id();
        gone_.post();
    }

  private:
    std::thread::id& by_;
    Semaphore& gone_;
};

TEST(WorkerPool, WorkersDestroyWhatIsDiscarded) {
    std::thread::id by;
    Semaphore gone;
    Pool pool(1);
    pool.discard(std::make_shared<Tells>(by, gone));
    pool.empty_waste();
    gone.wait();
    EXPECT_NE(by, std::this_thread::get_id());
}

// What is left of results goes to the workers when the owner next sends something.
TEST(WorkerPool, WorkersDestroyWhatIsLeftOfResults) {
    std::thread::id by;
    Semaphore gone;
    FrameHeap heap;
    WorkerPool<int, std::shared_ptr<Tells>> pool(
        1, [] {}, [&](int&) { return std::make_shared<Tells>(by, gone); }, heap);
    WorkerPool<int, std::shared_ptr<Tells>>::Jobs jobs(&heap);
    jobs.push_back({1, 1, 0});
    pool.add(jobs);
    pool.wait(kNever);
    EXPECT_EQ(pool.take([](const auto&) {}), 1u);
    pool.empty_waste();
    gone.wait();
    EXPECT_NE(by, std::this_thread::get_id());
}

// What runs is finished, what waits is never started, and what either holds is let go.
TEST(WorkerPool, ItEndsWithWorkInHandAndJobsWaiting) {
    constexpr int kWorkers = 3;
    std::atomic<int> started{0}, finished{0};
    const auto held = std::make_shared<int>(0);
    Gate gate;
    std::thread opens([&] {
        for (int k = 0; k < kWorkers; ++k) gate.wait_for_one();
        // By now the pool is asked to end; were it not yet, more jobs might be started than counted here.
        std::this_thread::sleep_for(std::chrono::milliseconds(50));
        gate.open(kWorkers);
    });
    {
        Pool pool(kWorkers);
        for (std::uint64_t k = 0; k < 200; ++k)
            pool.add({job(1, k, [&, held] {
                ++started;
                gate.pass();
                return ++finished;
            })});
        while (started < kWorkers) std::this_thread::yield();
    }
    opens.join();
    EXPECT_EQ(started, kWorkers);
    EXPECT_EQ(finished, kWorkers);
    EXPECT_EQ(held.use_count(), 1);
}

// Everything at once, for the sanitizers too.
TEST(WorkerPool, EveryJobAskedForHasItsResultOnce) {
    Pool pool(4);
    constexpr std::uint64_t kJobs = 3000;
    std::vector<int> results(kJobs, 0);
    std::uint64_t taken = 0;
    const auto collect = [&](std::vector<Pool::Done> done) {
        for (const Pool::Done& d : done) {
            ++results[d.key];
            ++taken;
        }
    };
    for (std::uint64_t k = 0; k < kJobs; ++k) {
        std::vector<Pool::Job> jobs;
        jobs.push_back(job(static_cast<double>(k % 17), k, [] { return 0; }));
        pool.add(std::move(jobs));
        pool.discard(std::make_shared<int>(0));
        if (k % 5 == 0) collect(pool.take());
    }
    while (taken < kJobs) collect(pool.take(kNever));
    EXPECT_EQ(results, std::vector<int>(kJobs, 1));
}

}  // namespace
}  // namespace carat
