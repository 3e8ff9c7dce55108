#pragma once
// Runs a check on every vector target that this build holds and this processor has, one after another.
#include <gtest/gtest.h>
#include <hwy/targets.h>

#include <cstdint>

namespace carat::test {

// check(): a callable; a failure in it names the target.
template <class Check>
void on_every_target(const Check& check) {
    const std::int64_t all = hwy::SupportedTargets();
    for (std::int64_t left = all; left != 0; left &= left - 1) {
        hwy::SetSupportedTargetsForTest(left & -left);
        hwy::GetChosenTarget().Update(hwy::SupportedTargets());
        SCOPED_TRACE(hwy::TargetName(left & -left));
        check();
    }
    hwy::SetSupportedTargetsForTest(0);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

}  // namespace carat::test
