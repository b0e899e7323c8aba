#include "simulated_robot_node_plant.h"

#include <algorithm>
#include <cmath>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kSettleTolerance = 1e-6;  // of the load
constexpr int kSettleSteps = 60;
constexpr int kStepsPerFactor =
    4;  // the shape changes little meanwhile, and the imbalance is brought down in each step

VecX makeCableZero(const std::vector<double>& values, int actuators) {
  if (values.empty()) return VecX::Zero(actuators);
  if (static_cast<int>(values.size()) != actuators) {
    throw ConfigError("cable zeros", std::to_string(values.size()) + " values",
                      std::to_string(actuators) + " values [m], one per actuator, or none");
  }
  return Eigen::Map<const VecX>(values.data(), actuators);
}

}  // namespace

RobotDescription makeDeviated(const RobotDescription& drawn, const PlantDeviations& deviations) {
  const double factor = deviations.stiffness_factor;
  if (!std::isfinite(factor) || factor <= 0) {
    throw ConfigError("stiffness_factor", std::to_string(factor), "a positive number, 1 for the drawn stiffness");
  }
  if (!std::isfinite(deviations.gravity_tilt)) {
    throw ConfigError("gravity_tilt", std::to_string(deviations.gravity_tilt), "an angle [rad]");
  }
  RobotDescription built = drawn;
  for (MaterialDescription& material : built.materials) material.young_modulus *= factor;
  built.gravity = Eigen::AngleAxisd(deviations.gravity_tilt, Vec3::UnitX()) * drawn.gravity;
  return built;
}

SimulatedPlant::SimulatedPlant(const RobotDescription& drawn, const PlantDeviations& deviations)
    : robot_(std::make_shared<RobotModel>(makeDeviated(drawn, deviations))),
      simulator_(robot_, kStepsPerFactor),
      actuation_(simulator_.makeActuation()),
      cable_zero_(makeCableZero(deviations.cable_zero, robot_->actuatorCount())),
      snapped_(actuation_.mode.size(), false) {
  std::fill(actuation_.mode.begin(), actuation_.mode.end(), Actuation::Mode::kDisplacement);
  settle();
}

void SimulatedPlant::settle() {
  actuation_.value = cable_zero_;
  simulator_.settle(actuation_, kSettleTolerance, kSettleSteps);
  if (simulator_.residualRelative() <= kSettleTolerance) return;
  throw ConfigError(
      "the simulated body finds no equilibrium under gravity and its cable zeros: check stiffness, "
      "gravity and zeros");
}

void SimulatedPlant::setSnapped(int actuator, bool snapped) {
  const auto i = static_cast<size_t>(actuator);
  snapped_[i] = snapped;
  actuation_.mode[i] = snapped ? Actuation::Mode::kEffort : Actuation::Mode::kDisplacement;
}

void SimulatedPlant::step(const VecX& reeled_in, double period) {
  actuation_.value = reeled_in + cable_zero_;
  for (size_t i = 0; i < snapped_.size(); ++i)
    if (snapped_[i]) actuation_.value[static_cast<Eigen::Index>(i)] = 0;  // N
  const ForwardStatus status = simulator_.step(actuation_, period);
  if (status == ForwardStatus::kSolved || status == ForwardStatus::kNotConverged) return;
  ++failed_steps_;
  const auto& nodes = simulator_.nodes();
  if (!std::all_of(nodes.begin(), nodes.end(), [](const Vec3& node) { return node.allFinite(); })) simulator_.reset();
}

}  // namespace sinew
