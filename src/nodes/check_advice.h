#pragma once

#include <string>
#include <vector>

#include "check_timing.h"

namespace sinew {

/// What would make the cycles of a robot shorter, in words: what it would spare first.
std::vector<std::string> advise(const RobotDescription& robot, const CycleTiming& timing);

}  // namespace sinew
