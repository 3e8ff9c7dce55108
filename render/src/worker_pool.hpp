// Threads that take the most urgent job first, and an owner that they never keep waiting.
//
// The owner adds jobs and takes results without a lock and without malloc, so a worker that the system has
// put aside in a critical section holds up other workers at most. Measured with both cores wanted by others:
// with one mutex for all, one of a hundred frames waited 4 to 20 ms for it.
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

#include "frame_heap.hpp"
#include "hand_over.hpp"

namespace carat {

// Runs jobs that each make a Result of a Task. A job is named by a key: one that is running, or whose result
// has not been taken yet, is not started again. All members are for one thread, the owner.
template <class Task, class Result>
class WorkerPool {
  public:
    using Clock = std::chrono::steady_clock;
    struct Job {
        double priority = 0;  // the greatest first
        std::uint64_t key = 0;
        Task task;
    };
    using Jobs = std::pmr::vector<Job>;
    struct Done {
        std::uint64_t key = 0;
        Result result{};
        std::exception_ptr error;  // instead of a result
    };
    using Run = std::function<Result(Task&)>;

    // prepare() runs in each thread before its first job, run() once a job. At least one thread. The heap is
    // the owner's and outlives this.
    WorkerPool(int threads, const std::function<void()>& prepare, Run run, FrameHeap& heap)
        : run_(std::move(run)), heap_(heap) {
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
        round_ = heap_.share<Round>();
    }

    // In the owner's heap. Leaves none.
    void add(Jobs& jobs) {
        if (jobs.empty()) return;
        const std::size_t wakes = std::min(jobs.size(), threads_.size());
        round_->unstarted += static_cast<int>(jobs.size());
        send(std::move(jobs));
        jobs.clear();
        for (std::size_t k = 0; k < wakes; ++k) wake_.post();
    }

    // Has a worker destroy something.
    void discard(std::shared_ptr<const void> something) { waste_.push_back(std::move(something)); }
    // Sends it off; add() does so too.
    void empty_waste() {
        if (waste_.empty() && spent_.empty()) return;
        send(Jobs(&heap_));
        wake_.post();
    }

    // Waits for a result until the deadline if there is none but work in hand.
    void wait(Clock::time_point deadline) {
        do arrived_.reset();
        while (!ready() && arrived_.wait_until(deadline));
    }
    // How often wait() may have slept.
    std::uint64_t sleeps() const { return arrived_.sleeps(); }
    // Calls each(Done&) for the results since the last call; what it leaves there, a worker destroys. The
    // number of results.
    template <class Function>
    std::size_t take(Function each) {
        std::size_t count = 0;
        typename HandOver<Done>::Batch done = done_.take();
        done.each([&](Done& d) {
            taken_.push_back(d.key);
            ++count;
        });
        done.each(each);
        spent_.append(std::move(done));
        return count;
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
    struct Message {
        Jobs jobs;
        std::shared_ptr<Round> round;
        std::pmr::vector<std::uint64_t> taken;  // keys of results that the owner has taken
        std::pmr::vector<std::shared_ptr<const void>> waste;
        typename HandOver<Done>::Batch spent;
    };
    // What a worker is to destroy.
    struct Rubbish {
        std::vector<Entry> dropped;
        typename HandOver<Message>::Batch read;
    };

    static bool less_urgent(const Entry& l, const Entry& r) { return l.job.priority < r.job.priority; }

    void send(Jobs jobs) {
        inbox_.give({std::move(jobs), round_, std::move(taken_), std::move(waste_), std::move(spent_)});
        taken_.clear();
        waste_.clear();
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
                more = run_first(lock);
                if (!lock) lock.lock();
                std::swap(rubbish, rubbish_);
                lock.unlock();
            }
        }
    }

    // Precondition: locked.
    void read_inbox() {
        typename HandOver<Message>::Batch messages = inbox_.take();
        messages.each([&](Message& m) {
            // Who asked before taking the result has what was asked for.
            const std::unordered_set<std::uint64_t> taken(m.taken.begin(), m.taken.end());
            for (const std::uint64_t key : taken) busy_.erase(key);
            remove_if([&](const Entry& e) { return e.round->dropped || taken.contains(e.job.key); });
            for (Job& job : m.jobs) queue_.push_back({std::move(job), m.round});
            std::make_heap(queue_.begin(), queue_.end(), less_urgent);
        });
        rubbish_.read.append(std::move(messages));
    }

    template <class Predicate>
    void remove_if(Predicate unwanted) {
        const auto end =
            std::partition(queue_.begin(), queue_.end(), [&](const Entry& e) { return !unwanted(e); });
        for (auto it = end; it != queue_.end(); ++it) drop(std::move(*it));
        queue_.erase(end, queue_.end());
    }
    void drop(Entry entry) {
        --entry.round->unstarted;
        arrived_.post();
        rubbish_.dropped.push_back(std::move(entry));
    }

    // Takes the first job, runs it unlocked and gives its result. False, and still locked, if there is none.
    bool run_first(std::unique_lock<std::mutex>& lock) {
        read_inbox();
        while (!queue_.empty()) {
            std::pop_heap(queue_.begin(), queue_.end(), less_urgent);
            Entry entry = std::move(queue_.back());
            queue_.pop_back();
            if (entry.round->dropped || !busy_.insert(entry.job.key).second) {  // or asked for twice
                drop(std::move(entry));
            } else {
                ++running_;
                --entry.round->unstarted;
                lock.unlock();
                run(std::move(entry.job));
                return true;
            }
        }
        return false;
    }

    void run(Job job) {
        Done done{job.key, {}, {}};
        {
            Task task = std::move(job.task);  // what it holds goes before its result shows
            try {
                done.result = run_(task);
            } catch (...) {
                done.error = std::current_exception();
            }
        }
        done_.give(std::move(done));
        --running_;
        arrived_.post();
    }

    const Run run_;
    // The owner's.
    FrameHeap& heap_;
    std::shared_ptr<Round> round_ = heap_.share<Round>();
    std::pmr::vector<std::uint64_t> taken_{&heap_};
    std::pmr::vector<std::shared_ptr<const void>> waste_{&heap_};
    typename HandOver<Done>::Batch spent_;
    // Between the owner and the workers.
    HandOver<Message> inbox_{&heap_};
    HandOver<Done> done_{std::pmr::new_delete_resource()};
    Semaphore wake_, arrived_;
    std::atomic<int> running_{0};
    std::atomic<bool> stop_{false};
    // The workers'.
    std::mutex mutex_;
    std::vector<Entry> queue_;
    std::unordered_set<std::uint64_t> busy_;  // running, or done and not known to be taken
    Rubbish rubbish_;
    std::vector<std::thread> threads_;
};

}  // namespace carat
