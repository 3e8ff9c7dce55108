// How threads pass things on without locks: who gives or takes is never held up by a thread that the system
// has put aside in the middle of it.
#pragma once

#include <semaphore.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <ctime>
#include <memory_resource>
#include <utility>

namespace carat {

// Any number of threads give; whoever takes gets all of it, in the order given. Nodes lie in the given
// memory.
template <class T>
class HandOver {
    struct Node {
        Node(T&& v, Node* n) : value(std::move(v)), next(n) {}
        T value;
        Node* next;
    };

  public:
    // What was taken. Its memory goes back with it: in whichever thread it is destroyed.
    class Batch {
      public:
        Batch() = default;
        Batch(Batch&& other) noexcept { swap(other); }
        Batch& operator=(Batch&& other) noexcept {
            Batch(std::move(other)).swap(*this);
            return *this;
        }
        ~Batch() {
            while (first_ != nullptr)
                std::pmr::polymorphic_allocator<>(memory_).delete_object(std::exchange(first_, first_->next));
        }
        bool empty() const { return first_ == nullptr; }
        template <class Function>
        void each(Function function) {
            for (Node* n = first_; n != nullptr; n = n->next) function(n->value);
        }
        // Precondition: of one HandOver.
        void append(Batch other) {
            if (empty()) return swap(other);
            if (other.empty()) return;
            last_->next = std::exchange(other.first_, nullptr);
            last_ = other.last_;
        }

      private:
        friend class HandOver;
        // The last given is the first of the list.
        Batch(Node* list, std::pmr::memory_resource* memory) : last_(list), memory_(memory) {
            while (list != nullptr) {
                Node* const before = std::exchange(list->next, first_);
                first_ = std::exchange(list, before);
            }
        }
        void swap(Batch& other) noexcept {
            std::swap(first_, other.first_);
            std::swap(last_, other.last_);
            std::swap(memory_, other.memory_);
        }
        Node *first_ = nullptr, *last_ = nullptr;
        std::pmr::memory_resource* memory_ = nullptr;
    };

    explicit HandOver(std::pmr::memory_resource* memory) : memory_(memory) {}
    HandOver(const HandOver&) = delete;
    HandOver& operator=(const HandOver&) = delete;
    ~HandOver() { (void)take(); }

    void give(T value) {
        Node* const node = std::pmr::polymorphic_allocator<>(memory_).template new_object<Node>(
            std::move(value), head_.load(std::memory_order_relaxed));
        while (!head_.compare_exchange_weak(node->next, node, std::memory_order_release,
                                            std::memory_order_relaxed)) {
        }
    }
    Batch take() { return {head_.exchange(nullptr, std::memory_order_acquire), memory_}; }
    bool empty() const { return head_.load(std::memory_order_acquire) == nullptr; }

  private:
    std::pmr::memory_resource* memory_;
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
        if (sem_trywait(&semaphore_) == 0) return true;
        ++sleeps_;
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
    // How often wait_until() may have slept; for the thread that calls it.
    std::uint64_t sleeps() const { return sleeps_; }
    // Forgets all posts so far.
    void reset() {
        while (sem_trywait(&semaphore_) == 0) {
        }
    }

  private:
    sem_t semaphore_{};
    std::uint64_t sleeps_ = 0;
};

}  // namespace carat
