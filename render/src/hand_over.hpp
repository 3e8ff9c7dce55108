// How threads pass things on without locks: who gives or takes is never held up by a thread that the system
// has put aside in the middle of it.
#pragma once

#include <semaphore.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <ctime>
#include <utility>
#include <vector>

namespace carat {

// Any number of threads give; whoever takes gets all of it, in the order given.
template <class T>
class HandOver {
  public:
    HandOver() = default;
    HandOver(const HandOver&) = delete;
    HandOver& operator=(const HandOver&) = delete;
    ~HandOver() { (void)take(); }

    void give(T value) {
        Node* const node = new Node{std::move(value), head_.load(std::memory_order_relaxed)};
        while (!head_.compare_exchange_weak(node->next, node, std::memory_order_release,
                                            std::memory_order_relaxed)) {
        }
    }
    std::vector<T> take() {
        std::vector<T> out;
        for (Node* n = head_.exchange(nullptr, std::memory_order_acquire); n != nullptr;) {
            out.push_back(std::move(n->value));
            delete std::exchange(n, n->next);
        }
        std::reverse(out.begin(), out.end());
        return out;
    }
    bool empty() const { return head_.load(std::memory_order_acquire) == nullptr; }

  private:
    struct Node {
        T value;
        Node* next;
    };
    std::atomic<Node*> head_{nullptr};
};

// Counts posts; each lets one wait pass.
class Semaphore {
  public:
    using Clock = std::chrono::steady_clock;

    Semaphore() { sem_init(&semaphore_, 0, 0); }
    ~Semaphore() { sem_destroy(&semaphore_); }
    Semaphore(const Semaphore&) = delete;
    Semaphore& operator=(const Semaphore&) = delete;

    void post() { sem_post(&semaphore_); }
    void wait() {
        while (sem_wait(&semaphore_) != 0) {
        }
    }
    // False once the time has come. The end of time is never.
    bool wait_until(Clock::time_point deadline) {
        if (deadline == Clock::time_point::max()) return wait(), true;
        const auto since = std::max(deadline.time_since_epoch(), Clock::duration::zero());
        const auto seconds = std::chrono::floor<std::chrono::seconds>(since);
        timespec at{};
        at.tv_sec = seconds.count();
        at.tv_nsec = std::chrono::nanoseconds(since - seconds).count();
        while (sem_clockwait(&semaphore_, CLOCK_MONOTONIC, &at) != 0)
            if (errno != EINTR) return false;
        return true;
    }
    // Forgets all posts so far.
    void reset() {
        while (sem_trywait(&semaphore_) == 0) {
        }
    }

  private:
    sem_t semaphore_{};
};

}  // namespace carat
