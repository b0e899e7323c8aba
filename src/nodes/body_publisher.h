#pragma once

#include <ros/node_handle.h>
#include <semaphore.h>
#include <sensor_msgs/JointState.h>
#include <sinew/ContactArray.h>
#include <tf2_ros/transform_broadcaster.h>

#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "ros_conversions.h"
#include "sinew/common/newest_wins.h"
#include "sinew/inverse/inverse_controller.h"

namespace sinew {

/// Publishes the deformed shape as `body_state`, what it touches as `contacts`, where the controller believes the
/// obstacles to be as `obstacles`, the frames `effector_<name>`, and of a robot with a carrier how far that has
/// travelled as `joint_states`, from a thread of its own.
class BodyPublisher {
 public:
  BodyPublisher(ros::NodeHandle node, std::shared_ptr<const RobotModel> robot);
  ~BodyPublisher();
  BodyPublisher(const BodyPublisher&) = delete;
  BodyPublisher& operator=(const BodyPublisher&) = delete;

  /// Takes a copy of the controller's present shape and contacts. Cycle thread: neither waits nor allocates.
  void hand(const InverseController& controller, const CycleInput& input, const CycleOutput& output);

 private:
  struct PressedContact {
    ContactRow row;
    double force;  ///< N
    double gap;    ///< m
  };
  struct Snapshot {
    std::vector<Vec3> nodes;                ///< m, those of the surface
    std::vector<std::vector<Vec3>> cables;  ///< m
    VecX effort;                            ///< N
    VecX effectors;                         ///< m
    double travel = 0;                      ///< m, of the carrier
    std::vector<PressedContact> contacts;   ///< room for all; the leading `contact_count` count
    std::size_t contact_count = 0;
    std::vector<ObstacleState> obstacles;
  };

  static Snapshot makeSnapshot(const RobotModel& robot);
  void run();
  void publishBody(const Snapshot& snapshot, const ros::Time& stamp);
  void publishFrames(const Snapshot& snapshot, const ros::Time& stamp);
  void publishContacts(const Snapshot& snapshot, const ros::Time& stamp);
  void publishObstacles(const Snapshot& snapshot, const ros::Time& stamp);
  void publishCarrier(const Snapshot& snapshot, const ros::Time& stamp);

  std::shared_ptr<const RobotModel> robot_;
  NewestWins<Snapshot> newest_;
  BodyState message_;
  ContactArray contacts_;
  TrackedObstacles obstacles_;
  sensor_msgs::JointState joints_;
  std::vector<std::string> part_owners_;
  std::vector<geometry_msgs::TransformStamped> frames_;
  ros::Publisher publisher_, contacts_publisher_, obstacles_publisher_, joints_publisher_;
  tf2_ros::TransformBroadcaster broadcaster_;
  sem_t handed_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sinew
