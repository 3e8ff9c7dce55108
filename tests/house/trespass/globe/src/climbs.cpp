// Input of the test house.include_arrows_sees_trespass; never compiled.
#include "../../codec/src/secret.hpp"
