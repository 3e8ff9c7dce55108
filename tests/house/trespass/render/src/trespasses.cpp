// Input of the test house.include_arrows_sees_trespass; never compiled.
#include "carat/globe/globe.hpp"
#include "carat/preprocess/preprocess.hpp"
// Blocks keep their order only apart.
#include <vulkan/vulkan.h>
