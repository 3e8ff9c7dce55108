#include "build_passes.hpp"

#include <algorithm>

namespace carat {

bool BuildContext::has_level(StepKind kind, int level) const {
    for (std::size_t step = 0; step < steps(level); ++step)
        if (!store.has({kind, level, step})) return false;
    return true;
}

void ErrorSum::add(const ErrorSum& other) {
    max = std::max(max, other.max);
    squares += other.squares;
    count += other.count;
}

}  // namespace carat
