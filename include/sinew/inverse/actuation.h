#pragma once

#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// Actuation of the forward problem, one entry per actuator. A displacement is what the winch has reeled in: the cable
/// is then taut at that length, or hangs slack. An effort acts as given; a carrier is driven by displacement
/// only.
struct Actuation {
  enum class Mode { kDisplacement, kEffort };
  std::vector<Mode> mode;
  VecX value;  ///< m or N
};

}  // namespace sinew
