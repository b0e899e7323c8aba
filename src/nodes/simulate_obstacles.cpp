#include "simulate_obstacles.h"

#include <algorithm>
#include <array>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr int kValues = 8;
constexpr std::array<const char*, kValues> kParts = {"x", "y", "z", "qx", "qy", "qz", "qw", "present"};
constexpr int kPosition = 0, kOrientation = 3, kPresent = 7;

std::string makeColumn(const Obstacle& obstacle, int part) {
  return "obstacle_" + obstacle.name + "_" + kParts[static_cast<std::size_t>(part)];
}

VecX makeResting(const RobotModel& robot) {
  VecX values(kValues * static_cast<Eigen::Index>(robot.obstacles().size()));
  Eigen::Index first = 0;
  for (const Obstacle& obstacle : robot.obstacles()) {
    values.segment<3>(first + kPosition) = obstacle.pose.translation();
    values.segment<4>(first + kOrientation) = Eigen::Quaterniond(obstacle.pose.linear()).coeffs();
    values[first + kPresent] = 1;
    first += kValues;
  }
  return values;
}

void refuseOtherColumns(const CsvTable& table, const RobotModel& robot) {
  std::vector<std::string> known = {"t"};
  for (const Obstacle& obstacle : robot.obstacles()) {
    for (int part = 0; part < kValues; ++part) known.push_back(makeColumn(obstacle, part));
  }
  for (const std::string& column : table.columns()) {
    if (std::find(known.begin(), known.end(), column) != known.end()) continue;
    std::string names;
    for (const std::string& name : known) names += (names.empty() ? "" : ", ") + name;
    throw ConfigError(table.name(), "column " + column, "any of " + names);
  }
}

bool hasAny(const CsvTable& table, const Obstacle& obstacle, int first, int count) {
  for (int part = first; part < first + count; ++part) {
    if (table.has(makeColumn(obstacle, part))) return true;
  }
  return false;
}

MatX readValues(const CsvTable& table, const RobotModel& robot) {
  refuseOtherColumns(table, robot);
  MatX values = makeResting(robot).replicate(1, table.rows());
  Eigen::Index first = 0;
  for (const Obstacle& obstacle : robot.obstacles()) {
    const auto read = [&](int part, int count) {
      if (!hasAny(table, obstacle, part, count)) return;
      for (int k = part; k < part + count; ++k) {
        values.row(first + k) = table.numbers(makeColumn(obstacle, k)).transpose();
      }
    };
    read(kPosition, 3);
    read(kOrientation, 4);
    read(kPresent, 1);
    const auto norms = values.middleRows(first + kOrientation, 4).colwise().norm();
    if (values.cols() > 0 && !(norms.minCoeff() > 0.5)) {
      throw ConfigError(table.name() + ": " + makeColumn(obstacle, kOrientation), "no rotation", "a unit quaternion");
    }
    first += kValues;
  }
  return values;
}

}  // namespace

ObstacleSignal::ObstacleSignal(const RobotModel& robot) : values_(VecX::Zero(1), makeResting(robot)) {}

ObstacleSignal::ObstacleSignal(const CsvTable& table, const RobotModel& robot)
    : values_(table.risingNumbers("t"), readValues(table, robot)) {}

void ObstacleSignal::calcStates(double time, std::vector<ObstacleState>& states) const {
  VecX values;
  values_.calcValue(time, values);
  states.resize(static_cast<std::size_t>(values.size() / kValues));
  Eigen::Index first = 0;
  for (ObstacleState& state : states) {
    const Eigen::Quaterniond rotation(values.segment<4>(first + kOrientation).eval().data());
    state.pose = Eigen::Translation3d(values.segment<3>(first + kPosition)) * rotation.normalized();
    state.present = values[first + kPresent] >= 0.5;
    first += kValues;
  }
}

}  // namespace sinew
