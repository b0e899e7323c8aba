#pragma once

#include <string>

#include "sinew/common/types.h"

namespace sinew {

/// Pose of link `frame` in link `reference` of a URDF, every joint at zero [m]. Throws ConfigError when the file cannot
/// be read or a link is not in it.
Pose readUrdfPose(const std::string& urdf_file, const std::string& reference, const std::string& frame);

}  // namespace sinew
