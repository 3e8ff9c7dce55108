// Threads that take the most urgent job first.
#pragma once

#include <algorithm>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <mutex>
#include <thread>
#include <unordered_set>
#include <utility>
#include <vector>

namespace carat {

// Runs jobs that each yield a Result. A job is named by a key: one that is running, or whose result has not
// been taken yet, is not started again. Thread-safe for one owner (who asks and takes) and its workers.
template <class Result>
class WorkerPool {
  public:
    using Clock = std::chrono::steady_clock;
    struct Job {
        double priority = 0;  // the greatest first
        std::uint64_t key = 0;
        std::function<Result()> run;
    };
    struct Done {
        std::uint64_t key = 0;
        Result result{};
        std::exception_ptr error;  // instead of a result
    };

    // prepare() runs in each thread before its first job.
    WorkerPool(int threads, const std::function<void()>& prepare) {
        for (int k = 0; k < threads; ++k)
            threads_.emplace_back([this, prepare] {
                prepare();
                work();
            });
    }
    // Drops what has not been started and waits for what has.
    ~WorkerPool() {
        {
            const std::lock_guard lock(mutex_);
            stop_ = true;
            heap_.clear();
        }
        wake_.notify_all();
        for (std::thread& t : threads_) t.join();
    }
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    bool has_threads() const { return !threads_.empty(); }

    // Drops what has not been started.
    void drop_unstarted() {
        const std::lock_guard lock(mutex_);
        heap_.clear();
    }

    void add(std::vector<Job> jobs) {
        if (jobs.empty()) return;
        {
            const std::lock_guard lock(mutex_);
            for (Job& job : jobs) {
                if (busy_.contains(job.key)) continue;
                heap_.push_back(std::move(job));
                std::push_heap(heap_.begin(), heap_.end(), less_urgent);
            }
        }
        wake_.notify_all();
    }

    // Runs the most urgent job in this thread, if it has at least this priority. False if there is none.
    bool run_one(double least_priority) {
        std::unique_lock lock(mutex_);
        if (heap_.empty() || heap_.front().priority < least_priority) return false;
        run_first(lock);
        return true;
    }

    // Results since the last call. Waits for one until the deadline if there is none but work in hand.
    std::vector<Done> take(Clock::time_point deadline) {
        std::unique_lock lock(mutex_);
        const auto ready = [this] { return !done_.empty() || (busy_.empty() && heap_.empty()); };
        // A deadline at the end of time overflows in some libraries' conversions to the system's clock.
        if (deadline == Clock::time_point::max())
            arrived_.wait(lock, ready);
        else
            arrived_.wait_until(lock, deadline, ready);
        for (const Done& d : done_) busy_.erase(d.key);
        return std::exchange(done_, {});
    }
    std::vector<Done> take() { return take(Clock::time_point::min()); }

  private:
    static bool less_urgent(const Job& l, const Job& r) { return l.priority < r.priority; }

    void work() {
        std::unique_lock lock(mutex_);
        for (;;) {
            wake_.wait(lock, [this] { return stop_ || !heap_.empty(); });
            if (stop_) return;
            run_first(lock);
        }
    }

    // Takes the first job, runs it unlocked and keeps its result.
    void run_first(std::unique_lock<std::mutex>& lock) {
        std::pop_heap(heap_.begin(), heap_.end(), less_urgent);
        const Job job = std::move(heap_.back());
        heap_.pop_back();
        if (!busy_.insert(job.key).second) return;  // asked for twice
        lock.unlock();
        Done done{job.key, {}, {}};
        try {
            done.result = job.run();
        } catch (...) {
            done.error = std::current_exception();
        }
        lock.lock();
        done_.push_back(std::move(done));
        arrived_.notify_one();
    }

    std::mutex mutex_;
    std::condition_variable wake_, arrived_;
    std::vector<Job> heap_;
    std::unordered_set<std::uint64_t> busy_;  // running, or done and not taken
    std::vector<Done> done_;
    bool stop_ = false;
    std::vector<std::thread> threads_;
};

}  // namespace carat
