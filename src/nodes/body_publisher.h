#pragma once

#include <ros/node_handle.h>
#include <semaphore.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "ros_conversions.h"
#include "sinew/common/newest_wins.h"
#include "sinew/inverse/inverse_controller.h"

namespace sinew {

/// Publishes the deformed shape as `body_state`, and the frames `effector_<name>`, from a thread of its own.
class BodyPublisher {
 public:
  BodyPublisher(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot);
  ~BodyPublisher();
  BodyPublisher(const BodyPublisher&) = delete;
  BodyPublisher& operator=(const BodyPublisher&) = delete;

  /// Takes a copy of the controller's present shape. Cycle thread: neither waits nor allocates.
  void hand(const InverseController& controller, const CycleOutput& output, const ros::Time& stamp);

 private:
  struct Snapshot {
    ros::Time stamp;
    std::vector<Vec3> nodes;                ///< m, those of the surface
    std::vector<std::vector<Vec3>> cables;  ///< m
    VecX effort;                            ///< N
    VecX effectors;                         ///< m
  };

  static Snapshot makeSnapshot(const RobotModel& robot);
  void run();
  void publishBody(const Snapshot& snapshot);
  void publishFrames(const Snapshot& snapshot);

  std::shared_ptr<const RobotModel> robot_;
  NewestWins<Snapshot> newest_;
  BodyState message_;
  std::vector<geometry_msgs::TransformStamped> frames_;
  ros::Publisher publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  sem_t handed_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sinew
