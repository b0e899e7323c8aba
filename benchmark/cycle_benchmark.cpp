// Times the stages of a control cycle, and the steps of a simulated robot, on one core.
// usage: cycle_benchmark ROOT [SCENE ...]; ROOT is the project's folder. See scripts/benchmark

#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "measuring.h"
#include "robot_scene.h"
#include "sinew/robot/robot_description.h"
#include "timed_robot.h"

namespace sinew {
namespace {

void run(const RobotScene& scene) {
  RobotDescription description = readRobotDescription(scene.file);
  if (scene.self) description.contacts.self = true;
  const auto robot = std::make_shared<const RobotModel>(description);
  StageSamples samples;
  const std::vector<VecX> commands = timeController(scene, robot, samples);
  samples.print(scene.name, *robot, scene.thesis);
  timePlant(scene, robot, commands);
}

int runAll(const std::string& root, const std::vector<std::string>& names) {
  const std::vector<RobotScene> scenes = makeRobotScenes(root);
  std::string known;
  for (const RobotScene& scene : scenes) known += " " + scene.name;
  for (const std::string& name : names) {
    if (std::any_of(scenes.begin(), scenes.end(), [&](const RobotScene& scene) { return scene.name == name; }))
      continue;
    std::fprintf(stderr, "no scene %s; there are:%s\n", name.c_str(), known.c_str());
    return 2;
  }
  for (const RobotScene& scene : scenes) {
    if (names.empty() || std::find(names.begin(), names.end(), scene.name) != names.end()) run(scene);
  }
  return 0;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: cycle_benchmark ROOT [SCENE ...]\n");
    return 2;
  }
  try {
    sinew::pinToOneCore();
    return sinew::runAll(argv[1], std::vector<std::string>(argv + 2, argv + argc));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "cycle_benchmark: %s\n", error.what());
    return 1;
  }
}
