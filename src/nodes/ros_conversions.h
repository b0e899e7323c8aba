#pragma once

#include <geometry_msgs/Point.h>
#include <geometry_msgs/Point32.h>
#include <geometry_msgs/Pose.h>
#include <ros/time.h>
#include <sinew/ActuatorCommand.h>
#include <sinew/ActuatorState.h>
#include <sinew/BodyState.h>
#include <sinew/Contact.h>
#include <sinew/ControllerState.h>
#include <sinew/EffectorTargets.h>
#include <sinew/TrackedObstacles.h>

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "refusal_log.h"
#include "sinew/inverse/inverse_controller.h"
#include "stage_statistics.h"

namespace sinew {

/// Where messages become values of the core and back. Whatever comes from a wire is checked here, whole or not at all.

geometry_msgs::Point toPoint(const Vec3& position);
geometry_msgs::Point32 toPoint32(const Vec3& position);
Vec3 toVec3(const geometry_msgs::Point& point);
geometry_msgs::Pose toPoseMessage(const Pose& pose);
/// The quaternion's length may be off by rounding.
Pose toPose(const geometry_msgs::Pose& pose);

/// m from the robot: beyond it a target or an obstacle is a fault, not a wish.
constexpr double kFarthest = 1000;

/// Which message a value came from.
struct MessageStamp {
  ros::Time stamp;
  std::uint32_t sequence = 0;
};

/// What the driver says of the actuators, in the order of the robot's description.
struct DriverReading {
  VecX measured;              ///< m
  VecX applied;               ///< m
  bool all_measured = false;  ///< the last read of every actuator succeeded
  bool all_zeroed = false;    ///< every actuator knows its zero
  std::uint8_t driver_state = ActuatorState::OFF;
  std::uint32_t session = 0;
  std::uint32_t sequence = 0;  ///< of the last command accepted
  MessageStamp source;
  double receipt = -1;  ///< s, steady; negative before the first
};

DriverReading makeReading(const RobotModel& robot);

/// Fills `reading`, except for its receipt, or says why the message is refused.
std::optional<Refusal> updateReading(const ActuatorState& message, const RobotModel& robot, DriverReading& reading);

/// Sizes, names and finite numbers. `effectors` becomes the index of each name.
std::optional<Refusal> checkTargets(const EffectorTargets& message, const RobotModel& robot,
                                    std::vector<int>& effectors);

/// Sizes, names of tracked obstacles, finite positions and unit quaternions. `obstacles` becomes the index of each
/// name.
std::optional<Refusal> checkObstacles(const TrackedObstacles& message, const RobotModel& robot,
                                      std::vector<int>& obstacles);

/// One word for a driver state of ActuatorState: `HOLDING`.
const char* nameOfDriverState(std::uint8_t state);

/// The stages of ControllerState, in the order of `calcStageDurations`.
constexpr int kStages = 7;
void calcStageDurations(const StageTimes& times, double cycle, double* durations);

ActuatorCommand makeCommandMessage(const RobotModel& robot);
ControllerState makeStateMessage(const RobotModel& robot);
BodyState makeBodyMessage(const RobotModel& robot);
/// Every obstacle of the robot, where its description says.
TrackedObstacles makeObstaclesMessage(const RobotModel& robot);
/// Name of the obstacle that each part belongs to: what `ContactRow::obstacle` counts.
std::vector<std::string> listPartOwners(const RobotModel& robot);

struct CommandRecord;
struct CycleRecord;
void updateCommandMessage(const CommandRecord& record, ActuatorCommand& message);
/// All but the stamp, the stages and the deadlines missed. What was not modelled stays as it was.
void updateStateMessage(const RobotModel& robot, const CycleRecord& record, ControllerState& message);
/// `force` [N], `gap` [m].
Contact makeContactMessage(const ContactRow& row, double force, double gap, const std::vector<std::string>& owners);
void updateObstaclesMessage(const std::vector<ObstacleState>& obstacles, TrackedObstacles& message);
void updateStageMessages(const StageStatistics& statistics, std::vector<StageTime>& stages);

/// What a level leaves out, in words; empty for none.
const char* describe(OverloadLevel level);

/// Why a cycle was held or degraded, in words.
const char* describe(const CycleOutput& output);

}  // namespace sinew
