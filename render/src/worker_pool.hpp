// Threads that take the most urgent job first, and an owner that they never keep waiting.
//
// The owner adds jobs and takes results without a lock, so a worker that the system has put aside in a
// critical section holds up other workers at most. Measured with both cores wanted by others: with one mutex
// for all, one of a hundred frames waited 4 to 20 ms for it.
#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstdint>
#include <exception>
#include <functional>
#include <iterator>
#include <limits>
#include <memory>
#include <mutex>
#include <thread>
#include <unordered_set>
#include <utility>
#include <vector>

#include "hand_over.hpp"

namespace carat {

// Runs jobs that each yield a Result. A job is named by a key: one that is running, or whose result has not
// been taken yet, is not started again. All members are for one thread, the owner.
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

    // prepare() runs in each thread before its first job. At least one thread.
    WorkerPool(int threads, const std::function<void()>& prepare) {
        for (int k = 0; k < threads; ++k)
            threads_.emplace_back([this, prepare] {
                prepare();
                work();
            });
    }
    // Drops what has not been started and waits for what has.
    ~WorkerPool() {
        stop_ = true;
        for (std::size_t k = 0; k < threads_.size(); ++k) wake_.post();
        for (std::thread& t : threads_) t.join();
    }
    WorkerPool(const WorkerPool&) = delete;
    WorkerPool& operator=(const WorkerPool&) = delete;

    // Drops what has not been started.
    void drop_unstarted() {
        round_->dropped = true;
        round_ = std::make_shared<Round>();
    }

    void add(std::vector<Job> jobs) {
        if (jobs.empty()) return;
        const std::size_t wakes = std::min(jobs.size(), threads_.size());
        round_->unstarted += static_cast<int>(jobs.size());
        send(std::move(jobs));
        for (std::size_t k = 0; k < wakes; ++k) wake_.post();
    }

    // Has a worker destroy something.
    void discard(std::shared_ptr<const void> something) { waste_.push_back(std::move(something)); }
    // Sends it off; add() does so too.
    void empty_waste() {
        if (waste_.empty()) return;
        send({});
        wake_.post();
    }

    // Runs the most urgent job in this thread, if it has at least this priority. False if there is none, or
    // a worker is just choosing one.
    bool run_one(double least_priority) {
        std::unique_lock lock(mutex_, std::try_to_lock);
        return lock && run_first(lock, least_priority);
    }

    // Results since the last call. Waits for one until the deadline if there is none but work in hand.
    std::vector<Done> take(Clock::time_point deadline) {
        do arrived_.reset();
        while (!ready() && arrived_.wait_until(deadline));
        return take();
    }
    std::vector<Done> take() {
        std::vector<Done> out = done_.take();
        for (const Done& d : out) taken_.push_back(d.key);
        return out;
    }

  private:
    // Jobs added between two drops.
    struct Round {
        std::atomic<bool> dropped{false};
        std::atomic<int> unstarted{0};
    };
    struct Entry {
        Job job;
        std::shared_ptr<Round> round;
    };
    // What a worker is to destroy.
    struct Rubbish {
        std::vector<Entry> dropped;
        std::vector<std::shared_ptr<const void>> waste;
    };
    struct Message {
        std::vector<Job> jobs;
        std::shared_ptr<Round> round;
        std::vector<std::uint64_t> taken;  // keys of results that the owner has taken
        std::vector<std::shared_ptr<const void>> waste;
    };

    static bool less_urgent(const Entry& l, const Entry& r) { return l.job.priority < r.job.priority; }

    void send(std::vector<Job> jobs) {
        inbox_.give({std::move(jobs), round_, std::exchange(taken_, {}), std::exchange(waste_, {})});
    }

    // A result is there, or none will come. In this order: a job counts as running before it stops counting
    // as unstarted, and its result is there before it stops running.
    bool ready() const { return (round_->unstarted == 0 && running_ == 0) || !done_.empty(); }

    void work() {
        for (;;) {
            wake_.wait();
            for (bool more = true; more;) {
                if (stop_) return;
                Rubbish rubbish;  // destroyed unlocked
                std::unique_lock lock(mutex_);
                more = run_first(lock, std::numeric_limits<double>::lowest());
                if (!lock) lock.lock();
                std::swap(rubbish, rubbish_);
                lock.unlock();
            }
        }
    }

    // Precondition: locked.
    void read_inbox() {
        for (Message& m : inbox_.take()) {
            // Who asked before taking the result has what was asked for.
            const std::unordered_set<std::uint64_t> taken(m.taken.begin(), m.taken.end());
            for (const std::uint64_t key : taken) busy_.erase(key);
            remove_if([&](const Entry& e) { return e.round->dropped || taken.contains(e.job.key); });
            for (Job& job : m.jobs) heap_.push_back({std::move(job), m.round});
            std::move(m.waste.begin(), m.waste.end(), std::back_inserter(rubbish_.waste));
            std::make_heap(heap_.begin(), heap_.end(), less_urgent);
        }
    }

    template <class Predicate>
    void remove_if(Predicate unwanted) {
        const auto end =
            std::partition(heap_.begin(), heap_.end(), [&](const Entry& e) { return !unwanted(e); });
        for (auto it = end; it != heap_.end(); ++it) drop(std::move(*it));
        heap_.erase(end, heap_.end());
    }
    void drop(Entry entry) {
        --entry.round->unstarted;
        arrived_.post();
        rubbish_.dropped.push_back(std::move(entry));
    }

    // Takes the first job, runs it unlocked and gives its result. False, and still locked, if there is none.
    bool run_first(std::unique_lock<std::mutex>& lock, double least_priority) {
        read_inbox();
        while (!heap_.empty() && heap_.front().job.priority >= least_priority) {
            std::pop_heap(heap_.begin(), heap_.end(), less_urgent);
            Entry entry = std::move(heap_.back());
            heap_.pop_back();
            if (entry.round->dropped || !busy_.insert(entry.job.key).second) {  // or asked for twice
                drop(std::move(entry));
            } else {
                ++running_;
                --entry.round->unstarted;
                lock.unlock();
                run(entry.job);
                return true;
            }
        }
        return false;
    }

    void run(Job& job) {
        Done done{job.key, {}, {}};
        try {
            done.result = job.run();
        } catch (...) {
            done.error = std::current_exception();
        }
        job.run = {};  // what it holds goes before its result shows
        done_.give(std::move(done));
        --running_;
        arrived_.post();
    }

    // The owner's.
    std::shared_ptr<Round> round_ = std::make_shared<Round>();
    std::vector<std::uint64_t> taken_;
    std::vector<std::shared_ptr<const void>> waste_;
    // Between the owner and the workers.
    HandOver<Message> inbox_;
    HandOver<Done> done_;
    Semaphore wake_, arrived_;
    std::atomic<int> running_{0};
    std::atomic<bool> stop_{false};
    // The workers'; the owner tries the lock, but never waits for it.
    std::mutex mutex_;
    std::vector<Entry> heap_;
    std::unordered_set<std::uint64_t> busy_;  // running, or done and not known to be taken
    Rubbish rubbish_;
    std::vector<std::thread> threads_;
};

}  // namespace carat
