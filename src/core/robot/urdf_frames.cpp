#include "sinew/robot/urdf_frames.h"

#include <urdf_parser/urdf_parser.h>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

Pose toPose(const urdf::Pose& pose) {
  Pose result = Pose::Identity();
  result.linear() =
      Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z).toRotationMatrix();
  result.translation() = Vec3(pose.position.x, pose.position.y, pose.position.z);
  return result;
}

std::string linkNames(const urdf::ModelInterface& model) {
  std::string names = "one of its links:";
  for (const auto& link : model.links_) names += " " + link.first;
  return names;
}

Pose poseInRoot(const urdf::ModelInterface& model, const std::string& file, const std::string& name) {
  urdf::LinkConstSharedPtr link = model.getLink(name);
  if (!link) throw ConfigError(file + ": link", "'" + name + "'", linkNames(model));
  Pose pose = Pose::Identity();
  for (; link->parent_joint; link = link->getParent()) {
    pose = toPose(link->parent_joint->parent_to_joint_origin_transform) * pose;
  }
  return pose;
}

}  // namespace

Pose readUrdfPose(const std::string& urdf_file, const std::string& reference, const std::string& frame) {
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDFFile(urdf_file);
  if (!model) throw ConfigError(urdf_file, "no readable URDF", "a URDF file");
  return poseInRoot(*model, urdf_file, reference).inverse() * poseInRoot(*model, urdf_file, frame);
}

}  // namespace sinew
