// Input of the test house.include_arrows_sees_trespass; never compiled.
#include "carat/render/view.hpp"
#include "carat/synth/synth.hpp"
// Blocks keep their order only apart.
#include <vulkan/vulkan.h>
