// Golden files: what is in them, and the pinned hash of every height that a reader must find.
#pragma once

#include <array>
#include <cstdint>

namespace carat::test {

struct Golden {
    const char* file;       // in tests/codec/golden
    std::uint64_t heights;  // hash_heights() of walk.hpp
};

inline constexpr std::array<Golden, 9> kGolden{{
    {"example.carat", 0x57E3BA6755BDC5C3u},
    {"mixed_modes.carat", 0xD460C7E3440ECB84u},
    {"paper.carat", 0xCA845F6519C45D07u},
    {"deep_patch.carat", 0xC121181BEAD6061Eu},
    {"zero_pages.carat", 0xFD2D055B55D21818u},
    {"range.carat", 0xF6FE7CD9EF454173u},
    {"fitted.carat", 0x2AB4E7CB1BACC091u},
    {"default_gamma.carat", 0x682F96B944169B1Bu},
    {"default_range.carat", 0x682F96B944169B1Bu},
}};

}  // namespace carat::test
