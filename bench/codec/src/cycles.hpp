// The processor's time stamp counter: constant rate, not the core's own clock. Nanoseconds where there is
// none.
#pragma once

#include <cstdint>
#if defined(__x86_64__)
#include <x86intrin.h>
#else
#include <chrono>
#endif

namespace carat::bench {

inline std::uint64_t cycles_now() {
#if defined(__x86_64__)
    return __rdtsc();
#else
    return static_cast<std::uint64_t>(std::chrono::steady_clock::now().time_since_epoch().count());
#endif
}

}  // namespace carat::bench
