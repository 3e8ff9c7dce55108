// Views that the tests share: orbit, oblique, grazing, near the ground, poles, cube corners, antimeridian,
// random.
#pragma once

#include <string>
#include <vector>

#include "carat/render/view.hpp"
#include "render/cut/fake_repository.hpp"

namespace carat::test {

struct NamedView {
    std::string name;
    View view;
    ViewRequest request;  // of the same
};
// Named places in each manner, then `random` views from the seed.
std::vector<NamedView> test_views(const FakeRepository& repository, int random, unsigned seed);

}  // namespace carat::test
