// Objects that one thread may use at a time, lent out and taken back.
#pragma once

#include <functional>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace carat {

// Grows to the number of simultaneous borrowers. Thread-safe.
template <class T>
class Pool {
  public:
    using Make = std::function<std::unique_ptr<T>()>;
    explicit Pool(Make make) : make_(std::move(make)) {}

    class Lease {
      public:
        Lease(Pool& pool, std::unique_ptr<T> object) : pool_(pool), object_(std::move(object)) {}
        ~Lease() {
            const std::lock_guard lock(pool_.mutex_);
            pool_.idle_.push_back(std::move(object_));
        }
        Lease(const Lease&) = delete;
        Lease& operator=(const Lease&) = delete;
        T& operator*() const { return *object_; }
        T* operator->() const { return object_.get(); }

      private:
        Pool& pool_;
        std::unique_ptr<T> object_;
    };

    Lease borrow() {
        std::unique_lock lock(mutex_);
        if (idle_.empty())
            return Lease(*this, make_());  // make_ runs under the lock: it may copy a shared original
        std::unique_ptr<T> object = std::move(idle_.back());
        idle_.pop_back();
        return Lease(*this, std::move(object));
    }

  private:
    Make make_;
    std::mutex mutex_;
    std::vector<std::unique_ptr<T>> idle_;
};

}  // namespace carat
