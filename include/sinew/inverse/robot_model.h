#pragma once

#include <memory>
#include <string>
#include <vector>

#include "sinew/inverse/obstacle.h"
#include "sinew/mesh/surface.h"
#include "sinew/mesh/tet_mesh.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

class FemModel;
class Cable;
class PointEffector;

/// A robot ready to be simulated or controlled: description, mesh, elements, cables and effectors, none of which
/// changes afterwards. Shared by controller, forward simulator and display.
class RobotModel {
 public:
  /// Throws ConfigError when the description and the mesh do not make a robot.
  explicit RobotModel(const RobotDescription& description);
  RobotModel(const RobotDescription& description, const TetMesh& mesh);
  ~RobotModel();

  const RobotDescription& description() const { return description_; }
  const TetMesh& mesh() const { return mesh_; }
  const Surface& surface() const { return surface_; }
  const FemModel& fem() const { return *fem_; }
  const std::vector<Cable>& cables() const { return cables_; }
  const std::vector<PointEffector>& effectors() const { return effectors_; }
  const std::vector<Obstacle>& obstacles() const { return obstacles_; }
  /// The cables, then the carrier where there is one.
  const std::vector<ActuatorLimits>& actuators() const { return actuators_; }
  int actuatorCount() const { return static_cast<int>(actuators_.size()); }
  bool hasCarrier() const { return !description_.carrier.name.empty(); }
  /// m, what a displacement is to be measured against: a cable's length at rest, the body's size for the carrier.
  double actuatorLength(int actuator) const;
  int effectorCount() const;
  int effectorRows() const;  ///< controlled axes of all effectors together
  /// m a node may move in one linearisation; where there are contacts, none may jump over what is watched.
  double maxNodeStep() const;
  int maxContacts() const;        ///< 0 where there is nothing to touch
  int maxContactEntries() const;  ///< nodes of all contacts together
  /// Index by name, -1 when unknown.
  int findActuator(const std::string& name) const;
  int findEffector(const std::string& name) const;
  int findObstacle(const std::string& name) const;
  /// Suspicions that do not stop the robot: mesh quality, cable points outside the mesh with their distance, locking.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  RobotDescription description_;
  TetMesh mesh_;
  Surface surface_;
  std::unique_ptr<FemModel> fem_;
  std::vector<Cable> cables_;
  std::vector<ActuatorLimits> actuators_;
  double size_ = 0;  // m, of the body at rest
  std::vector<PointEffector> effectors_;
  std::vector<Obstacle> obstacles_;
  std::vector<std::string> warnings_;
};

}  // namespace sinew
