// The vector units that the processor has, one at a time.
#pragma once

#include <hwy/targets.h>

#include <cstdint>
#include <vector>

namespace carat::test {

inline std::vector<std::int64_t> vector_targets() {
    std::vector<std::int64_t> out;
    for (std::int64_t left = hwy::SupportedTargets(); left != 0; left &= left - 1)
        out.push_back(left & -left);
    return out;
}

// Has the library choose this one of Highway's targets while it lives.
class OneVectorTarget {
  public:
    explicit OneVectorTarget(std::int64_t target) {
        hwy::SetSupportedTargetsForTest(target);
        hwy::GetChosenTarget().Update(target);
    }
    ~OneVectorTarget() {
        hwy::SetSupportedTargetsForTest(0);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
    }
    OneVectorTarget(const OneVectorTarget&) = delete;
    OneVectorTarget& operator=(const OneVectorTarget&) = delete;
};

}  // namespace carat::test
