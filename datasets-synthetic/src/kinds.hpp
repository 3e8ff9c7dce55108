// The table of kinds.
#pragma once

#include "carat/synth/synth.hpp"

namespace carat::synth {

const KindInfo& info_of(Kind kind);
/// The body that a kind lives on.
Ellipsoid body_of(Kind kind);

}  // namespace carat::synth
