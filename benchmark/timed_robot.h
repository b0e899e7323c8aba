#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "robot_scene.h"
#include "sinew/inverse/inverse_controller.h"
#include "stage_samples.h"

namespace sinew {

/// Runs a controller through a scene. see(cycle, input, output) after each one; cycles of the lead-in are negative.
void runController(const RobotScene& scene, InverseController& controller,
                   const std::function<void(int, const CycleInput&, const CycleOutput&)>& see);

/// Times the controller's stages; returns its commands [m], those of the lead-in as well.
std::vector<VecX> timeController(const RobotScene& scene, std::shared_ptr<const RobotModel> robot,
                                 StageSamples& samples);

/// Times the steps of the simulated robot along these commands, and prints them.
void timePlant(const RobotScene& scene, std::shared_ptr<const RobotModel> robot, const std::vector<VecX>& commands);

}  // namespace sinew
