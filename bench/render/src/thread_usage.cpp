#include "thread_usage.hpp"

#include <time.h>

#ifdef __linux__
#include <fcntl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#endif

namespace carat::bench {
namespace {

#ifdef __linux__
// The second number of the thread's schedstat: nanoseconds of waiting for a processor.
class SchedulerStatistics {
  public:
    ~SchedulerStatistics() {
        if (file_ >= 0) close(file_);
    }
    double ready_ms() const {
        std::array<char, 96> text{};
        unsigned long long ran = 0, ready = 0;
        if (file_ < 0 || pread(file_, text.data(), text.size() - 1, 0) <= 0 ||
            std::sscanf(text.data(), "%llu %llu", &ran, &ready) != 2)
            return 0;
        return 1e-6 * static_cast<double>(ready);
    }

  private:
    int file_ = open("/proc/thread-self/schedstat", O_RDONLY | O_CLOEXEC);
};
#endif

}  // namespace

ThreadUsage ThreadUsage::now() {
    ThreadUsage out;
    timespec t{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
    out.cpu_ms = 1e3 * static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_nsec);
#ifdef __linux__
    rusage usage{};
    getrusage(RUSAGE_THREAD, &usage);
    out.preempted = usage.ru_nivcsw;
    out.slept = usage.ru_nvcsw;
    out.faults = usage.ru_minflt + usage.ru_majflt;
    thread_local const SchedulerStatistics statistics;
    out.ready_ms = statistics.ready_ms();
#endif
    return out;
}

}  // namespace carat::bench
