#pragma once

#include <urdf_parser/urdf_parser.h>

#include <string>

#include "sinew/common/types.h"

namespace sinew {

Pose toPose(const urdf::Pose& pose);

/// Throws ConfigError when the file holds no URDF.
urdf::ModelInterfaceSharedPtr readUrdf(const std::string& file);

/// Throws ConfigError when there is no such link.
urdf::LinkConstSharedPtr findLink(const urdf::ModelInterface& model, const std::string& file, const std::string& name);

}  // namespace sinew
