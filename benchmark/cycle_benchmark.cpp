// Times the stages of a control cycle, and the steps of a simulated robot, on one core.
// usage: cycle_benchmark CONFIG [SCENE ...]; CONFIG is the folder of the robots. See scripts/benchmark

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "duration_sample.h"
#include "real_time.h"
#include "sinew/fem/fem_model.h"
#include "sinew/inverse/forward_simulator.h"
#include "sinew/inverse/inverse_controller.h"
#include "sinew/robot/robot_description.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr int kStepsPerFactor = 4;           // of the simulated robot
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// A robot whose first effector goes round a horizontal circle.
struct Scene {
  std::string name;
  std::string file;
  Vec3 centre;                           // m
  double radius;                         // m
  double turn;                           // s
  double rate;                           // Hz, of the controller
  double plant_rate;                     // Hz, of the simulated robot
  std::map<std::string, double> thesis;  // ms by stage; its scene adds an obstacle and 76 contacts
};

std::vector<Scene> makeScenes(const std::string& config) {
  return {{"trunk",
           config + "/trunk/trunk.yaml",
           Vec3(0, 0, 0.19),
           0.04,
           8,
           100,
           100,
           {{"compliance", 10.09}, {"qp", 4.91}, {"cycle", 34.52}}}};
}

void pinToOneCore() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(sched_getcpu(), &cores);
  sched_setaffinity(0, sizeof cores, &cores);
}

/// Sleeps as long as the work took: the kernel stops real-time threads that never do.
void rest(double worked) {
  std::this_thread::sleep_for(std::chrono::duration<double>(worked));
}

const char* nameInstructionSet() {
#if defined(__AVX512F__)
  return "avx512";
#elif defined(__AVX2__)
  return "avx2";
#elif defined(__SSE4_2__)
  return "sse4.2";
#else
  return "baseline";
#endif
}

Vec3 calcTarget(const Scene& scene, double time) {
  const double angle = kTurn * time / scene.turn;
  return scene.centre + scene.radius * Vec3(std::cos(angle), std::sin(angle), 0);
}

int countRows(const RobotModel& robot) {
  int rows = robot.actuatorCount();
  for (const EffectorDescription& effector : robot.description().effectors) {
    for (bool controlled : effector.axes) rows += controlled;
  }
  return rows;
}

/// One line of the report, without its end.
void printStage(const std::string& scene, const RobotModel& robot, const std::string& stage,
                const DurationSample& sample, double thesis) {
  std::printf(
      "scene=%s dofs=%d rows=%d contacts=0 threads=1 isa=%s stage=%s median_ms=%.3f p99_ms=%.3f max_ms=%.3f "
      "thesis_ms=%.2f",
      scene.c_str(), robot.fem().size(), countRows(robot), nameInstructionSet(), stage.c_str(),
      1e3 * sample.calcQuantile(0.5), 1e3 * sample.calcQuantile(0.99), 1e3 * sample.calcQuantile(1), thesis);
}

/// The controller's stages over one turn; returns the commands [m], one a cycle.
std::vector<VecX> timeController(const Scene& scene, std::shared_ptr<const RobotModel> robot) {
  InverseController controller(robot);
  controller.resynchronise(VecX::Zero(robot->actuatorCount()));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted.front() = true;
  input.period = 1 / scene.rate;
  const int cycles = static_cast<int>(scene.turn * scene.rate);
  DurationSample assembly, factor, compliance, qp, cycle;
  std::vector<VecX> commands;
  for (int k = -cycles / 4; k < cycles; ++k) {  // the first quarter leads to the circle
    input.targets.head<3>() = calcTarget(scene, k / scene.rate);
    controller.step(input, output);
    rest(output.times.cycle);
    if (k < 0) continue;
    assembly.add(output.times.assembly);
    factor.add(output.times.factor);
    compliance.add(output.times.compliance);
    qp.add(output.times.qp);
    cycle.add(output.times.cycle);
    commands.push_back(output.displacement);
  }
  const std::vector<std::pair<std::string, const DurationSample*>> stages = {
      {"assembly", &assembly}, {"factor", &factor}, {"compliance", &compliance}, {"qp", &qp}, {"cycle", &cycle}};
  for (const auto& [stage, sample] : stages) {
    const auto thesis = scene.thesis.find(stage);
    printStage(scene.name, *robot, stage, *sample, thesis == scene.thesis.end() ? kNone : thesis->second);
    std::printf("\n");
  }
  return commands;
}

/// The simulated robot pulled along the commands.
void timePlant(const Scene& scene, std::shared_ptr<const RobotModel> robot, const std::vector<VecX>& commands) {
  using Clock = std::chrono::steady_clock;
  ForwardSimulator simulator(robot, kStepsPerFactor);
  Actuation actuation = simulator.makeActuation();
  actuation.value = commands.front();
  simulator.settle(actuation, 1e-3);
  DurationSample steps;
  const auto stride = static_cast<std::size_t>(scene.rate / scene.plant_rate);
  for (std::size_t k = 0; k < commands.size(); k += stride) {
    actuation.value = commands[k];
    const Clock::time_point begin = Clock::now();
    simulator.step(actuation, 1 / scene.plant_rate);
    const double worked = std::chrono::duration<double>(Clock::now() - begin).count();
    steps.add(worked);
    rest(worked);
  }
  printStage(scene.name + "_plant", *robot, "cycle", steps, kNone);
  std::printf(" core_percent=%.1f\n", 100 * steps.calcMean() * scene.plant_rate);
}

void run(const Scene& scene) {
  const auto robot = std::make_shared<const RobotModel>(readRobotDescription(scene.file));
  timePlant(scene, robot, timeController(scene, robot));
}

int runAll(const std::string& config, const std::vector<std::string>& names) {
  std::map<std::string, Scene> scenes;
  std::string known;
  for (const Scene& scene : makeScenes(config)) {
    scenes[scene.name] = scene;
    known += " " + scene.name;
  }
  for (const std::string& name : names) {
    if (scenes.count(name) > 0) continue;
    std::fprintf(stderr, "no scene %s; there are:%s\n", name.c_str(), known.c_str());
    return 2;
  }
  for (const auto& [name, scene] : scenes) {
    if (names.empty() || std::find(names.begin(), names.end(), name) != names.end()) run(scene);
  }
  return 0;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: cycle_benchmark CONFIG [SCENE ...]\n");
    return 2;
  }
  try {
    sinew::pinToOneCore();
    sinew::requestRealTime(sinew::kCyclePriority);  // as the controller's cycle runs, where that is allowed
    return sinew::runAll(argv[1], std::vector<std::string>(argv + 2, argv + argc));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cycle_benchmark: %s\n", error.what());
    return 1;
  }
}
