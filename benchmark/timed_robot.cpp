#include "timed_robot.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <limits>

#include "measuring.h"
#include "sinew/inverse/forward_simulator.h"

namespace sinew {
namespace {

constexpr int kStepsPerFactor = 4;  // of the simulated robot

std::vector<ObstacleState> placeObstacles(const RobotScene& scene, const RobotModel& robot, double time) {
  std::vector<ObstacleState> states;
  for (const Obstacle& obstacle : robot.obstacles()) states.push_back({obstacle.pose, true});
  if (scene.place_obstacles && !states.empty()) scene.place_obstacles(time, states);
  return states;
}

}  // namespace

void runController(const RobotScene& scene, InverseController& controller,
                   const std::function<void(int, const CycleInput&, const CycleOutput&)>& see) {
  controller.resynchronise(VecX::Zero(controller.robot().actuatorCount()));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.period = 1 / scene.rate;
  for (int k = -scene.leadInCycles(); k < scene.timedCycles(); ++k) {
    const double time = k / scene.rate;
    const VecX targets = scene.target(time);
    input.targets.head(targets.size()) = targets;
    std::fill_n(input.targeted.begin(), targets.size() / 3, true);
    input.obstacles = placeObstacles(scene, controller.robot(), time);
    controller.step(input, output);
    see(k, input, output);
  }
}

std::vector<VecX> timeController(const RobotScene& scene, std::shared_ptr<const RobotModel> robot,
                                 StageSamples& samples) {
  InverseController controller(robot);
  std::vector<VecX> commands;
  runController(scene, controller, [&](int cycle, const CycleInput&, const CycleOutput& output) {
    rest(output.times.cycle);
    if (cycle >= 0) samples.add(output);
    commands.push_back(output.displacement);
  });
  return commands;
}

void timePlant(const RobotScene& scene, std::shared_ptr<const RobotModel> robot, const std::vector<VecX>& commands) {
  using Clock = std::chrono::steady_clock;
  ForwardSimulator simulator(robot, kStepsPerFactor);
  Actuation actuation = simulator.makeActuation();
  actuation.value = commands.front();
  simulator.settle(actuation, 1e-3);
  DurationSample steps;
  ContactCounts contacts;
  for (std::size_t k = 0; k < commands.size(); ++k) {
    const int cycle = static_cast<int>(k) - scene.leadInCycles();
    simulator.setObstacles(placeObstacles(scene, *robot, cycle / scene.rate));
    actuation.value = commands[k];
    const Clock::time_point begin = Clock::now();
    simulator.step(actuation, 1 / scene.rate);
    const double worked = std::chrono::duration<double>(Clock::now() - begin).count();
    rest(worked);
    if (cycle < 0) continue;
    steps.add(worked);
    contacts.all.push_back(simulator.contacts().size());
    contacts.pressing.push_back(static_cast<int>((simulator.contactForce().array() > 0).count()));
  }
  printStage(scene.name + "_plant", *robot, "cycle", steps, contacts, std::numeric_limits<double>::quiet_NaN());
  std::printf(" core_percent=%.1f\n", 100 * steps.calcMean() * scene.rate);
  std::fflush(stdout);
}

}  // namespace sinew
