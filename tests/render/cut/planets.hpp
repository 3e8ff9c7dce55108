// The repositories that the tests share, made once a process.
#pragma once

#include "render/cut/fake_repository.hpp"

namespace carat::test {

// 9 x 9 diamonds, Earth, rough, refined everywhere to level 5 and to level 12 around one place; every refined
// vertex moves a little.
const FakeRepository& rough_earth();
// 5 x 5 diamonds, Mars, uniform depth, no residuals of vertices.
const FakeRepository& plain_mars();
// 17 x 17 diamonds, a sphere of 1000 km with a constant height.
const FakeRepository& smooth_ball();

}  // namespace carat::test
