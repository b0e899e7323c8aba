#include "urdf_model.h"

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

std::string linkNames(const urdf::ModelInterface& model) {
  std::string names = "one of its links:";
  for (const auto& link : model.links_) names += " " + link.first;
  return names;
}

}  // namespace

Pose toPose(const urdf::Pose& pose) {
  Pose result = Pose::Identity();
  result.linear() =
      Eigen::Quaterniond(pose.rotation.w, pose.rotation.x, pose.rotation.y, pose.rotation.z).toRotationMatrix();
  result.translation() = Vec3(pose.position.x, pose.position.y, pose.position.z);
  return result;
}

urdf::ModelInterfaceSharedPtr readUrdf(const std::string& file) {
  urdf::ModelInterfaceSharedPtr model = urdf::parseURDFFile(file);
  if (!model) throw ConfigError(file, "no readable URDF", "a URDF file");
  return model;
}

urdf::LinkConstSharedPtr findLink(const urdf::ModelInterface& model, const std::string& file, const std::string& name) {
  urdf::LinkConstSharedPtr link = model.getLink(name);
  if (!link) throw ConfigError(file + ": link", "'" + name + "'", linkNames(model));
  return link;
}

}  // namespace sinew
