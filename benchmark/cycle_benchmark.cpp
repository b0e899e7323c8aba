// Times the stages of a control cycle, and the steps of a simulated robot, on one core.
// usage: cycle_benchmark CONFIG [SCENE ...]; CONFIG is the folder of the robots. See scripts/benchmark

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "duration_sample.h"
#include "real_time.h"
#include "sinew/common/csv_table.h"
#include "sinew/common/sampled_signal.h"
#include "sinew/fem/fem_model.h"
#include "sinew/inverse/forward_simulator.h"
#include "sinew/inverse/inverse_controller.h"
#include "sinew/robot/robot_description.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr int kStepsPerFactor = 4;           // of the simulated robot
constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// What a robot does while it is timed.
struct Scene {
  std::string name;
  std::string file;
  std::function<VecX(double)> target;                                        // m of the first effectors, by time in s
  std::function<void(double, std::vector<ObstacleState>&)> place_obstacles;  // likewise; empty: they stay
  double duration;                                                           // s
  std::map<std::string, double> thesis;                                      // ms by stage, of its scene of that kind
  double rate = 100;                                                         // Hz, of controller and simulated robot
  bool self = false;                                                         // every part may touch every other
};

/// A horizontal circle, one turn in `turn` [s].
std::function<VecX(double)> makeCircle(const Vec3& centre, double radius, double turn) {
  return [=](double time) -> VecX {
    const double angle = kTurn * time / turn;
    return centre + radius * Vec3(std::cos(angle), std::sin(angle), 0);
  };
}

/// From one point to another and back.
std::function<VecX(double)> makeSway(const Vec3& from, const Vec3& to, double period) {
  return [=](double time) -> VecX { return from + (to - from) * (0.5 - 0.5 * std::cos(kTurn * time / period)); };
}

/// The shipped targets of the named effectors.
std::function<VecX(double)> readTargets(const std::string& file, const std::vector<std::string>& effectors) {
  const CsvTable table = CsvTable::fromFile(file);
  MatX targets(3 * effectors.size(), table.rows());
  for (int row = 0; row < targets.rows(); ++row) {
    targets.row(row) = table.numbers("target_" + effectors[row / 3] + "_" + "xyz"[row % 3]).transpose();
  }
  return [signal = SampledSignal(table.risingNumbers("t"), targets)](double time) {
    VecX value;
    signal.calcValue(time, value);
    return value;
  };
}

/// Moves the first obstacle along x [m] and back.
std::function<void(double, std::vector<ObstacleState>&)> makePush(double way, double period) {
  return [=](double time, std::vector<ObstacleState>& obstacles) {
    obstacles.front().pose.translation().x() += way * (0.5 - 0.5 * std::cos(kTurn * time / period));
  };
}

std::vector<Scene> makeScenes(const std::string& config) {
  return {{"trunk", config + "/trunk/trunk.yaml", makeCircle(Vec3(0, 0, 0.19), 0.04, 8), {}, 8, {}},
          {"trunk_contact",
           config + "/trunk_cylinder/trunk_cylinder.yaml",
           makeCircle(Vec3(0, 0, 0.195), 0.01, 8),
           makePush(-0.033, 8),
           8,
           {{"compliance", 10.09}, {"qp", 4.91}, {"cycle", 34.52}}},
          {"finger_contact",
           config + "/finger/finger.yaml",
           makeSway(Vec3(0, 0.005, 0.098), Vec3(0, 0.012, 0.075), 4),
           {},
           8,
           {{"compliance", 0.64}, {"qp", 0.08}, {"cycle", 4.79}}},
          {"beam_contact",
           config + "/beam/beam.yaml",
           readTargets(config + "/beam/sway.csv", {"tip"}),
           {},
           16,
           {{"compliance", 3.38}, {"qp", 0.63}, {"cycle", 13.17}}},
          {"gripper_contact",
           config + "/gripper/gripper.yaml",
           readTargets(config + "/gripper/close.csv", {"tip_1", "tip_2", "tip_3"}),
           {},
           10,
           {}},
          {"tentacle_contact",
           config + "/tentacle/tentacle.yaml",
           readTargets(config + "/tentacle/curl.csv", {"tip"}),
           {},
           16,
           {}},
          {"trunk_self", config + "/trunk/trunk.yaml", makeCircle(Vec3(0, 0, 0.19), 0.04, 8), {}, 8, {}, 100, true}};
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

/// One line of the report, without its end.
void printStage(const std::string& scene, const RobotModel& robot, const std::string& stage,
                const DurationSample& sample, int contacts, double thesis) {
  std::printf(
      "scene=%s dofs=%d rows=%d contacts=%d threads=1 isa=%s stage=%s median_ms=%.3f p99_ms=%.3f max_ms=%.3f "
      "thesis_ms=%.2f",
      scene.c_str(), robot.fem().size(), robot.actuatorCount() + robot.effectorRows(), contacts, nameInstructionSet(),
      stage.c_str(), 1e3 * sample.calcQuantile(0.5), 1e3 * sample.calcQuantile(0.99), 1e3 * sample.calcQuantile(1),
      thesis);
}

/// Durations of every stage, and how many contacts there were at most.
struct StageSamples {
  DurationSample assembly, factor, detection, compliance, qp, cycle;
  int contacts = 0;

  void add(const CycleOutput& output) {
    assembly.add(output.times.assembly);
    factor.add(output.times.factor);
    detection.add(output.times.detection);
    compliance.add(output.times.compliance);
    qp.add(output.times.qp);
    cycle.add(output.times.cycle);
    contacts = std::max(contacts, output.contacts.count);
  }

  void print(const Scene& scene, const RobotModel& robot) const {
    const std::vector<std::pair<std::string, const DurationSample*>> stages = {
        {"assembly", &assembly},     {"factor", &factor}, {"detection", &detection},
        {"compliance", &compliance}, {"qp", &qp},         {"cycle", &cycle}};
    for (const auto& [stage, sample] : stages) {
      const auto thesis = scene.thesis.find(stage);
      printStage(scene.name, robot, stage, *sample, contacts, thesis == scene.thesis.end() ? kNone : thesis->second);
      std::printf("\n");
    }
  }
};

std::vector<ObstacleState> makeResting(const RobotModel& robot) {
  std::vector<ObstacleState> states;
  for (const Obstacle& obstacle : robot.obstacles()) states.push_back({obstacle.pose, true});
  return states;
}

/// The controller's stages; returns the commands [m], one a cycle.
std::vector<VecX> timeController(const Scene& scene, std::shared_ptr<const RobotModel> robot) {
  InverseController controller(robot);
  controller.resynchronise(VecX::Zero(robot->actuatorCount()));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.period = 1 / scene.rate;
  const std::vector<ObstacleState> resting = makeResting(*robot);
  const int cycles = static_cast<int>(scene.duration * scene.rate);
  StageSamples samples;
  std::vector<VecX> commands;
  for (int k = -cycles / 4; k < cycles; ++k) {  // the first quarter leads to the curve
    const double time = k / scene.rate;
    const VecX targets = scene.target(time);
    input.targets.head(targets.size()) = targets;
    std::fill_n(input.targeted.begin(), targets.size() / 3, true);
    input.obstacles = resting;
    if (scene.place_obstacles && k >= 0) scene.place_obstacles(time, input.obstacles);
    controller.step(input, output);
    rest(output.times.cycle);
    if (k < 0) continue;
    samples.add(output);
    commands.push_back(output.displacement);
  }
  samples.print(scene, *robot);
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
  int contacts = 0;
  std::vector<ObstacleState> obstacles;
  for (std::size_t k = 0; k < commands.size(); ++k) {
    obstacles = makeResting(*robot);
    if (scene.place_obstacles) scene.place_obstacles(static_cast<double>(k) / scene.rate, obstacles);
    simulator.setObstacles(obstacles);
    actuation.value = commands[k];
    const Clock::time_point begin = Clock::now();
    simulator.step(actuation, 1 / scene.rate);
    const double worked = std::chrono::duration<double>(Clock::now() - begin).count();
    steps.add(worked);
    rest(worked);
    contacts = std::max(contacts, simulator.contacts().size());
  }
  printStage(scene.name + "_plant", *robot, "cycle", steps, contacts, kNone);
  std::printf(" core_percent=%.1f\n", 100 * steps.calcMean() * scene.rate);
}

void run(const Scene& scene) {
  RobotDescription description = readRobotDescription(scene.file);
  if (scene.self) description.contacts.self = true;
  const auto robot = std::make_shared<const RobotModel>(description);
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
