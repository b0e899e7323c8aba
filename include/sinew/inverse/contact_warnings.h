#pragma once

#include <string>
#include <vector>

#include "sinew/inverse/robot_model.h"

namespace sinew {

/// What makes a robot's contacts suspicious before it moves: obstacles that overlap the body at rest, or lie inside it,
/// and surfaces that are watched for much farther than the mesh is fine.
std::vector<std::string> findContactWarnings(const RobotModel& robot);

}  // namespace sinew
