#include "ros_conversions.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cycle_record.h"
#include "sinew/robot/robot_description.h"

namespace sinew {

namespace {

constexpr std::array<const char*, kStages> kStageNames = {"assembly", "factor",  "detection", "compliance",
                                                          "qp",       "advance", "cycle"};

std::string quote(const std::string& name) {
  return "'" + name + "'";
}

constexpr double kRounding = 1e-9;  // N or m
constexpr char kGaveWay[] = "an effort limit gave way: see limits";

bool gaveWay(const CycleOutput& output) {
  return output.overload == OverloadLevel::kNone ||
         std::any_of(output.limits.begin(), output.limits.end(),
                     [](const ActiveLimitReport& limit) { return limit.violation > kRounding; });
}

/// Index of every name, each known and each at most once.
template <typename Find>
std::optional<Refusal> checkNames(const std::vector<std::string>& names, const char* noun, Find find,
                                  std::vector<int>& indices) {
  indices.clear();
  for (const std::string& name : names) {
    const int index = find(name);
    if (index < 0)
      return Refusal{RefusalReason::kUnknownName, "the robot has no " + std::string(noun) + " " + quote(name)};
    if (std::find(indices.begin(), indices.end(), index) != indices.end()) {
      return Refusal{RefusalReason::kDuplicateName, std::string(noun) + " " + quote(name) + " is named twice"};
    }
    indices.push_back(index);
  }
  return std::nullopt;
}

bool isFinite(const geometry_msgs::Point& point) {
  return std::isfinite(point.x) && std::isfinite(point.y) && std::isfinite(point.z);
}

bool isFinite(const geometry_msgs::Quaternion& q) {
  return std::isfinite(q.x) && std::isfinite(q.y) && std::isfinite(q.z) && std::isfinite(q.w);
}

Eigen::Quaterniond toQuaternion(const geometry_msgs::Quaternion& q) {
  return Eigen::Quaterniond(q.w, q.x, q.y, q.z);
}

std::optional<Refusal> checkPose(const geometry_msgs::Pose& pose, const std::string& name) {
  constexpr double kTolerance = 0.01;  // of a quaternion's length, written with few digits
  if (!isFinite(pose.position) || !isFinite(pose.orientation)) {
    return Refusal{RefusalReason::kNotFinite, "the pose of obstacle " + quote(name) + " is not finite"};
  }
  if (std::abs(toQuaternion(pose.orientation).norm() - 1) > kTolerance) {
    return Refusal{RefusalReason::kOrientation,
                   "the orientation of obstacle " + quote(name) + " is no quaternion of length 1"};
  }
  return std::nullopt;
}

std::optional<Refusal> checkSizes(const ActuatorState& message, std::size_t count) {
  const std::array<std::size_t, 5> sizes = {message.name.size(), message.mode.size(), message.measured.size(),
                                            message.applied.size(), message.zero_valid.size()};
  const bool fits = std::all_of(sizes.begin(), sizes.end(), [count](std::size_t size) { return size == count; });
  if (fits && message.measured_valid.size() == count) return std::nullopt;
  return Refusal{RefusalReason::kWrongSize, "the driver's state needs " + std::to_string(count) +
                                                " entries in every list, one per actuator of the robot"};
}

double calcControlledDistance(const EffectorDescription& effector, const Vec3& difference) {
  Vec3 controlled = difference;
  for (int axis = 0; axis < 3; ++axis) {
    if (!effector.axes[static_cast<std::size_t>(axis)]) controlled[axis] = 0;
  }
  return controlled.norm();
}

std::uint8_t toStatus(CycleStatus status) {
  switch (status) {
    case CycleStatus::kSolved:
      return ActuatorCommand::OK;
    case CycleStatus::kDegraded:
      return ActuatorCommand::DEGRADED;
    case CycleStatus::kHeld:
      return ActuatorCommand::HELD;
  }
  return ActuatorCommand::HELD;
}

}  // namespace

const char* nameOf(RefusalReason reason) {
  constexpr std::array<const char*, kRefusalReasons> kNames = {
      "wrong_size", "unknown_name", "duplicate_name", "not_finite",  "unknown_frame",
      "stamp",      "jump",         "mode",           "not_tracked", "orientation"};
  return kNames[static_cast<std::size_t>(reason)];
}

geometry_msgs::Point toPoint(const Vec3& position) {
  geometry_msgs::Point point;
  point.x = position.x();
  point.y = position.y();
  point.z = position.z();
  return point;
}

geometry_msgs::Point32 toPoint32(const Vec3& position) {
  geometry_msgs::Point32 point;
  point.x = static_cast<float>(position.x());
  point.y = static_cast<float>(position.y());
  point.z = static_cast<float>(position.z());
  return point;
}

Vec3 toVec3(const geometry_msgs::Point& point) {
  return Vec3(point.x, point.y, point.z);
}

geometry_msgs::Pose toPoseMessage(const Pose& pose) {
  const Eigen::Quaterniond turn(pose.linear());
  geometry_msgs::Pose message;
  message.position = toPoint(pose.translation());
  message.orientation.w = turn.w();
  message.orientation.x = turn.x();
  message.orientation.y = turn.y();
  message.orientation.z = turn.z();
  return message;
}

Pose toPose(const geometry_msgs::Pose& message) {
  Pose pose = Pose::Identity();
  pose.linear() = toQuaternion(message.orientation).normalized().toRotationMatrix();
  pose.translation() = toVec3(message.position);
  return pose;
}

DriverReading makeReading(const RobotModel& robot) {
  DriverReading reading;
  reading.measured = VecX::Zero(robot.actuatorCount());
  reading.applied = VecX::Zero(robot.actuatorCount());
  return reading;
}

std::optional<Refusal> updateReading(const ActuatorState& message, const RobotModel& robot, DriverReading& reading) {
  const auto count = static_cast<std::size_t>(robot.actuatorCount());
  if (auto refusal = checkSizes(message, count)) return refusal;
  std::vector<int> indices;
  const auto find = [&robot](const std::string& name) { return robot.findActuator(name); };
  if (auto refusal = checkNames(message.name, "actuator", find, indices)) return refusal;
  for (std::size_t i = 0; i < count; ++i) {
    if (message.mode[i] != ActuatorCommand::DISPLACEMENT) {
      return Refusal{RefusalReason::kMode, "the driver reports no displacement for actuator " + quote(message.name[i])};
    }
    if (!std::isfinite(message.measured[i]) || !std::isfinite(message.applied[i])) {
      return Refusal{RefusalReason::kNotFinite,
                     "the driver's value for actuator " + quote(message.name[i]) + " is not finite"};
    }
  }
  reading.all_measured = true;
  reading.all_zeroed = true;
  for (std::size_t i = 0; i < count; ++i) {
    reading.measured[indices[i]] = message.measured[i];
    reading.applied[indices[i]] = message.applied[i];
    reading.all_measured = reading.all_measured && message.measured_valid[i];
    reading.all_zeroed = reading.all_zeroed && message.zero_valid[i];
  }
  reading.driver_state = message.driver_state;
  reading.session = message.session;
  reading.sequence = message.sequence;
  reading.source = {message.header.stamp, message.header.seq};
  return std::nullopt;
}

std::optional<Refusal> checkTargets(const EffectorTargets& message, const RobotModel& robot,
                                    std::vector<int>& effectors) {
  if (message.name.empty() || message.name.size() != message.pose.size()) {
    return Refusal{RefusalReason::kWrongSize, std::to_string(message.name.size()) + " effector names with " +
                                                  std::to_string(message.pose.size()) +
                                                  " poses; it takes one pose per name and at least one"};
  }
  const auto find = [&robot](const std::string& name) { return robot.findEffector(name); };
  if (auto refusal = checkNames(message.name, "effector", find, effectors)) return refusal;
  for (std::size_t i = 0; i < message.name.size(); ++i) {
    if (!isFinite(message.pose[i].position)) {
      return Refusal{RefusalReason::kNotFinite, "the target of effector " + quote(message.name[i]) + " is not finite"};
    }
  }
  return std::nullopt;
}

std::optional<Refusal> checkObstacles(const TrackedObstacles& message, const RobotModel& robot,
                                      std::vector<int>& obstacles) {
  const std::size_t count = message.name.size();
  if (count == 0 || message.pose.size() != count || message.present.size() != count) {
    return Refusal{RefusalReason::kWrongSize,
                   std::to_string(count) + " obstacle names with " + std::to_string(message.pose.size()) +
                       " poses and " + std::to_string(message.present.size()) +
                       " entries of present; it takes one of each per name and at least one"};
  }
  const auto find = [&robot](const std::string& name) { return robot.findObstacle(name); };
  if (auto refusal = checkNames(message.name, "obstacle", find, obstacles)) return refusal;
  for (std::size_t i = 0; i < count; ++i) {
    if (!robot.obstacles()[static_cast<std::size_t>(obstacles[i])].tracked) {
      return Refusal{RefusalReason::kNotTracked,
                     "obstacle " + quote(message.name[i]) + " stays where the robot's description puts it"};
    }
    if (!message.present[i]) continue;
    if (auto refusal = checkPose(message.pose[i], message.name[i])) return refusal;
  }
  return std::nullopt;
}

const char* nameOfDriverState(std::uint8_t state) {
  constexpr std::array<const char*, 7> kNames = {"OFF", "INITIALISING", "READY", "ACTIVE", "HOLDING", "SAFE", "FAULT"};
  return state < kNames.size() ? kNames[state] : "unknown";
}

void calcStageDurations(const StageTimes& times, double cycle, double* durations) {
  const std::array<double, kStages> values = {times.assembly, times.factor, times.detection, times.compliance, times.qp,
                                              times.advance,  cycle};
  std::copy(values.begin(), values.end(), durations);
}

ActuatorCommand makeCommandMessage(const RobotModel& robot) {
  ActuatorCommand message;
  message.header.frame_id = robot.description().frame;
  for (const ActuatorLimits& actuator : robot.actuators()) message.name.push_back(actuator.name);
  message.mode.assign(message.name.size(), ActuatorCommand::DISPLACEMENT);
  message.value.assign(message.name.size(), 0.0);
  message.effort.assign(message.name.size(), 0.0);
  return message;
}

ControllerState makeStateMessage(const RobotModel& robot) {
  ControllerState message;
  message.header.frame_id = robot.description().frame;
  for (const EffectorDescription& effector : robot.description().effectors) {
    EffectorState state;
    state.name = effector.name;
    message.effectors.push_back(state);
  }
  for (const ActuatorLimits& actuator : robot.actuators()) message.actuator.push_back(actuator.name);
  message.displacement.assign(message.actuator.size(), 0.0);
  message.effort.assign(message.actuator.size(), 0.0);
  message.limits.reserve(6 * message.actuator.size());
  message.inputs.reserve(message.effectors.size() + robot.obstacles().size() + 1);
  message.stages.resize(kStages);
  for (std::size_t stage = 0; stage < kStageNames.size(); ++stage) message.stages[stage].stage = kStageNames[stage];
  message.reason.reserve(128);
  return message;
}

BodyState makeBodyMessage(const RobotModel& robot) {
  BodyState message;
  message.header.frame_id = robot.description().frame;
  const Surface& surface = robot.surface();
  std::vector<std::uint32_t> vertex_of_node(robot.mesh().nodes.size(), 0);
  for (std::size_t vertex = 0; vertex < surface.nodes.size(); ++vertex) {
    vertex_of_node[static_cast<std::size_t>(surface.nodes[vertex])] = static_cast<std::uint32_t>(vertex);
  }
  message.vertices.resize(surface.nodes.size());
  for (const std::array<int, 3>& triangle : surface.triangles) {
    for (const int node : triangle) message.triangles.push_back(vertex_of_node[static_cast<std::size_t>(node)]);
  }
  for (const CableDescription& cable : robot.description().cables) {
    message.cable.push_back(cable.name);
    message.cable_tension_max.push_back(cable.tension.max);
  }
  message.cable_size.assign(message.cable.size(), 0);
  message.cable_tension.assign(message.cable.size(), 0.0);
  return message;
}

TrackedObstacles makeObstaclesMessage(const RobotModel& robot) {
  TrackedObstacles message;
  message.header.frame_id = robot.description().frame;
  for (const Obstacle& obstacle : robot.obstacles()) {
    message.name.push_back(obstacle.name);
    message.pose.push_back(toPoseMessage(obstacle.pose));
    message.present.push_back(true);
  }
  return message;
}

std::vector<std::string> listPartOwners(const RobotModel& robot) {
  std::vector<std::string> owners;
  for (const Obstacle& obstacle : robot.obstacles()) owners.insert(owners.end(), obstacle.parts.size(), obstacle.name);
  return owners;
}

Contact makeContactMessage(const ContactRow& row, double force, double gap, const std::vector<std::string>& owners) {
  Contact contact;
  contact.obstacle = row.obstacle < 0 ? "self" : owners[static_cast<std::size_t>(row.obstacle)];
  contact.point = toPoint(row.point);
  contact.normal.x = row.normal.x();
  contact.normal.y = row.normal.y();
  contact.normal.z = row.normal.z();
  contact.force = force;
  contact.gap = gap;
  return contact;
}

void updateObstaclesMessage(const std::vector<ObstacleState>& obstacles, TrackedObstacles& message) {
  for (std::size_t i = 0; i < message.name.size(); ++i) {
    message.pose[i] = toPoseMessage(obstacles[i].pose);
    message.present[i] = obstacles[i].present;
  }
}

void updateCommandMessage(const CommandRecord& record, ActuatorCommand& message) {
  message.session = record.session;
  message.sequence = record.sequence;
  message.status = toStatus(record.status);
  for (std::size_t i = 0; i < message.value.size(); ++i) {
    message.value[i] = record.displacement[static_cast<Eigen::Index>(i)];
    message.effort[i] = record.effort[static_cast<Eigen::Index>(i)];
  }
}

namespace {

void updateModelMessage(const RobotModel& robot, const CycleRecord& record, ControllerState& message) {
  const CycleOutput& output = record.output;
  for (std::size_t i = 0; i < message.effectors.size(); ++i) {
    const auto row = 3 * static_cast<Eigen::Index>(i);
    EffectorState& effector = message.effectors[i];
    const Vec3 position = output.effectors.segment<3>(row);
    const Vec3 target = record.targeted[i] ? Vec3(record.targets.segment<3>(row)) : position;
    effector.targeted = record.targeted[i];
    effector.target = toPoint(target);
    effector.position = toPoint(position);
    effector.error = calcControlledDistance(robot.description().effectors[i], target - position);
  }
  for (std::size_t i = 0; i < message.actuator.size(); ++i) {
    message.displacement[i] = output.displacement[static_cast<Eigen::Index>(i)];
    message.effort[i] = output.effort[static_cast<Eigen::Index>(i)];
  }
  message.effector_error = output.effector_error;
  message.goal_scale = output.goal_scale;
  message.residual = output.residual;
  message.residual_relative = output.residual_relative;
  message.limits.resize(output.limits.size());
  for (std::size_t i = 0; i < output.limits.size(); ++i) {
    const ActiveLimitReport& report = output.limits[i];
    message.limits[i].actuator = message.actuator[static_cast<std::size_t>(report.actuator)];
    message.limits[i].kind = static_cast<std::uint8_t>(report.kind);
    message.limits[i].value = report.value;
    message.limits[i].violation = report.violation;
  }
  const ContactReport& contacts = output.contacts;
  message.contacts = static_cast<std::uint32_t>(contacts.count);
  message.contacts_global = contacts.count == 0 || contacts.proved_global;
  message.search_out_of_time = contacts.count > 0 && contacts.out_of_time;
  message.declined_better = contacts.count > 0 && contacts.declined_better;
  message.contact_pieces = static_cast<std::uint32_t>(contacts.pieces);
  message.contact_nodes = static_cast<std::uint32_t>(contacts.nodes);
  message.qp_iterations = static_cast<std::uint32_t>(output.qp_iterations);
  message.qp_status = static_cast<std::uint8_t>(output.qp_status);
  message.newton_steps = static_cast<std::uint32_t>(output.newton_steps);
  message.overload_level = static_cast<std::uint8_t>(output.overload);
  message.linearisation_age = static_cast<std::uint32_t>(output.linearisation_age);
}

void updateInputMessages(const CycleRecord& record, std::vector<InputStamp>& inputs) {
  inputs.resize(record.input_count);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    inputs[i].topic = *record.inputs[i].topic;
    inputs[i].stamp = record.inputs[i].source.stamp;
    inputs[i].sequence = record.inputs[i].source.sequence;
  }
}

}  // namespace

void updateStateMessage(const RobotModel& robot, const CycleRecord& record, ControllerState& message) {
  message.status = record.status;
  message.reason = record.reason;
  message.session = record.session;
  message.sequence = record.sequence;
  message.period = record.period;
  message.cycle = record.cycle;
  if (record.modelled) updateModelMessage(robot, record, message);
  updateInputMessages(record, message.inputs);
}

void updateStageMessages(const StageStatistics& statistics, std::vector<StageTime>& stages) {
  for (std::size_t i = 0; i < stages.size(); ++i) {
    const int stage = static_cast<int>(i);
    stages[i].last = statistics.last(stage);
    stages[i].median = statistics.median(stage);
    stages[i].maximum = statistics.maximum(stage);
  }
}

const char* describe(OverloadLevel level) {
  switch (level) {
    case OverloadLevel::kOneNewtonStep:
      return "overload: one Newton step a cycle";
    case OverloadLevel::kNoExploration:
      return "overload: one Newton step a cycle, no search for other contacts";
    case OverloadLevel::kSharedLinearisation:
      return "overload: cycles share linearisations and their contacts";
    case OverloadLevel::kNone:
      break;
  }
  return "";
}

const char* describe(const CycleOutput& output) {
  if (output.status == CycleStatus::kSolved) return "";
  if (output.status == CycleStatus::kDegraded && !output.holds) return "an effector that is to hold cannot";
  if (output.status == CycleStatus::kDegraded && output.contacts.crowded) {
    return "more contacts than contacts.max_contacts has room for";
  }
  if (output.status == CycleStatus::kDegraded) return gaveWay(output) ? kGaveWay : describe(output.overload);
  switch (output.reason) {
    case HoldReason::kNotFinite:
      return "held: the model came to a value that is not finite";
    case HoldReason::kNotPositiveDefinite:
      return "held: the stiffness matrix is not positive definite";
    case HoldReason::kQpFailed:
      return "held: the quadratic program found no answer";
    case HoldReason::kNone:
      break;
  }
  return "held";
}

}  // namespace sinew
