#include "sinew/robot/urdf_frames.h"

#include "urdf_model.h"

namespace sinew {
namespace {

Pose poseInRoot(const urdf::ModelInterface& model, const std::string& file, const std::string& name) {
  urdf::LinkConstSharedPtr link = findLink(model, file, name);
  Pose pose = Pose::Identity();
  for (; link->parent_joint; link = link->getParent()) {
    pose = toPose(link->parent_joint->parent_to_joint_origin_transform) * pose;
  }
  return pose;
}

}  // namespace

Pose readUrdfPose(const std::string& urdf_file, const std::string& reference, const std::string& frame) {
  const urdf::ModelInterfaceSharedPtr model = readUrdf(urdf_file);
  return poseInRoot(*model, urdf_file, reference).inverse() * poseInRoot(*model, urdf_file, frame);
}

}  // namespace sinew
