// What the system did with the calling thread: to tell a program that is late from a machine that is busy.
#pragma once

#include <cstdint>

namespace carat::bench {

// Totals since the thread began; 0 where the system does not tell (everything but cpu_ms outside Linux).
struct ThreadUsage {
    double cpu_ms = 0;                                  // on a processor
    double ready_ms = 0;                                // ready to run, while others had the processors
    std::int64_t preempted = 0, slept = 0, faults = 0;  // involuntary and voluntary switches; pages

    static ThreadUsage now();
    friend ThreadUsage operator-(const ThreadUsage& l, const ThreadUsage& r) {
        return {l.cpu_ms - r.cpu_ms, l.ready_ms - r.ready_ms, l.preempted - r.preempted, l.slept - r.slept,
                l.faults - r.faults};
    }
};

}  // namespace carat::bench
