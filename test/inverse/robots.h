#pragma once

#include <memory>
#include <string>

#include "sinew/common/csv_table.h"
#include "sinew/common/sampled_signal.h"
#include "sinew/inverse/forward_simulator.h"
#include "sinew/inverse/inverse_controller.h"

namespace sinew {

inline RobotDescription readShippedRobot(const std::string& name) {
  return readRobotDescription(std::string(SINEW_SOURCE_DIR) + "/config/" + name + "/" + name + ".yaml");
}

inline std::shared_ptr<const RobotModel> makeRobot(const RobotDescription& description) {
  return std::make_shared<const RobotModel>(description);
}

/// Targets [m] of all effectors over time from config/`file`, in the layout of CycleInput.
inline SampledSignal readShippedTargets(const RobotModel& robot, const std::string& file) {
  const CsvTable table = CsvTable::fromFile(std::string(SINEW_SOURCE_DIR) + "/config/" + file);
  MatX targets(3 * robot.effectorCount(), table.rows());
  for (int row = 0; row < targets.rows(); ++row) {
    const std::string& effector = robot.description().effectors[row / 3].name;
    targets.row(row) = table.numbers("target_" + effector + "_" + "xyz"[row % 3]).transpose();
  }
  return SampledSignal(table.risingNumbers("t"), targets);
}

/// The shipped description without bounds on displacement, its rate, and tension above zero.
inline RobotDescription withoutRates(RobotDescription description) {
  for (CableDescription& cable : description.cables) cable.displacement.rate = kUnlimited;
  return description;
}

/// Cycles until neither command nor residual moves any more; returns the number of cycles, -1 when `max_cycles` pass.
inline int settle(InverseController& controller, const CycleInput& input, CycleOutput& output, double tolerance,
                  int max_cycles) {
  for (int k = 0; k < max_cycles; ++k) {
    const VecX before = output.displacement;
    if (controller.step(input, output) == CycleStatus::kHeld) return -1;
    if (k > 0 && (output.displacement - before).cwiseAbs().maxCoeff() < tolerance && output.residual_relative < 1e-8) {
      return k;
    }
  }
  return -1;
}

}  // namespace sinew
