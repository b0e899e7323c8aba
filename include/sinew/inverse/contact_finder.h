#pragma once

#include <memory>
#include <vector>

#include "sinew/common/types.h"
#include "sinew/contact/contact_list.h"
#include "sinew/inverse/obstacle.h"
#include "sinew/inverse/robot_model.h"
#include "sinew/inverse/stage_times.h"

namespace sinew {

/// Finds what a robot touches or is about to: obstacles where they are now, and itself, as its description says.
/// No allocation after construction.
class ContactFinder {
 public:
  explicit ContactFinder(const RobotModel& robot);
  ~ContactFinder();

  /// Whether the robot has anything to touch.
  bool active() const;
  ContactFinder* activeOrNull() { return active() ? this : nullptr; }

  /// Where the obstacles are from now on, in the order of the robot's description; a missing tail stays as it is.
  void setObstacles(const std::vector<ObstacleState>& obstacles);
  const std::vector<ObstacleState>& obstacles() const;

  /// Contacts with the mesh's nodes at `nodes` [m]; each row's obstacle is an index for `part`.
  const ContactList& find(const std::vector<Vec3>& nodes, StageTimes& times);
  const ContactList& list() const;
  /// Whether contacts in the nearer half of the watched distance have found no room.
  bool crowded() const;

  /// One rigid shape of an obstacle where it is now.
  struct Placed {
    const ObstacleShape* shape;
    Pose pose;
    int obstacle;  ///< index into the description's list
  };
  Placed part(int index) const;  ///< of a row's `obstacle`
  /// By how much the last `setObstacles` alone changed the gap of a row [m].
  double calcGapShift(int row) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sinew
