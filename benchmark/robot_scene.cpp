#include "robot_scene.h"

#include <algorithm>
#include <cmath>

#include "sinew/common/csv_table.h"
#include "sinew/common/sampled_signal.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad

using Target = std::function<VecX(double)>;
using Placement = std::function<void(double, std::vector<ObstacleState>&)>;

/// From 0 to 1 and back.
double calcSway(double time, double period) {
  return 0.5 - 0.5 * std::cos(kTurn * time / period);
}

/// A horizontal circle, one turn in `turn` [s].
Target makeCircle(const Vec3& centre, double radius, double turn) {
  return [=](double time) -> VecX {
    const double angle = kTurn * time / turn;
    return centre + radius * Vec3(std::cos(angle), std::sin(angle), 0);
  };
}

/// From one point to another and back.
Target makeSway(const Vec3& from, const Vec3& to, double period) {
  return [=](double time) -> VecX { return from + (to - from) * calcSway(time, period); };
}

/// The shipped targets of the named effectors.
Target readTargets(const std::string& file, const std::vector<std::string>& effectors) {
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

/// The first obstacle comes along x by `way` [m] in the `approach` [s] before time 0, then sways by `more` [m] beyond.
Placement makePush(double way, double approach, double more, double period) {
  return [=](double time, std::vector<ObstacleState>& obstacles) {
    const double share = std::min(std::max(1 + time / approach, 0.0), 1.0);
    const double beyond = time > 0 ? more * calcSway(time, period) : 0;
    obstacles.front().pose.translation().x() += way * share * share * (3 - 2 * share) + beyond;
  };
}

}  // namespace

std::vector<RobotScene> makeRobotScenes(const std::string& root) {
  const std::string config = root + "/config", own = root + "/benchmark";
  const std::string trunk = config + "/trunk/trunk.yaml";
  const Target circle = makeCircle(Vec3(0, 0, 0.19), 0.04, 8);
  std::vector<RobotScene> scenes;
  scenes.push_back({"trunk", trunk, circle, {}, 8, {}});
  scenes.push_back({"trunk_contact",
                    own + "/trunk_contact/trunk_contact.yaml",
                    makeCircle(Vec3(0, 0, 0.196), 0.002, 8),
                    makePush(-0.012, 2, 0.003, 8),
                    8,
                    {{"compliance", 10.09}, {"qp", 4.91}, {"cycle", 34.52}}});
  scenes.push_back({"finger_contact",
                    own + "/finger_contact/finger_contact.yaml",
                    makeSway(Vec3(0, 0.005, 0.098), Vec3(0, 0.012, 0.075), 4),
                    {},
                    8,
                    {{"compliance", 0.64}, {"qp", 0.08}, {"cycle", 4.79}}});
  scenes.push_back({"beam_contact",
                    own + "/beam_contact/beam_contact.yaml",
                    readTargets(config + "/beam/sway.csv", {"tip"}),
                    {},
                    16,
                    {{"compliance", 3.38}, {"qp", 0.63}, {"cycle", 13.17}}});
  scenes.push_back({"trunk_cylinder",
                    config + "/trunk_cylinder/trunk_cylinder.yaml",
                    makeCircle(Vec3(0, 0, 0.195), 0.01, 8),
                    makePush(0, 1, -0.033, 8),
                    8,
                    {}});
  scenes.push_back({"gripper_contact",
                    config + "/gripper/gripper.yaml",
                    readTargets(config + "/gripper/close.csv", {"tip_1", "tip_2", "tip_3"}),
                    {},
                    10,
                    {}});
  scenes.push_back({"tentacle_contact",
                    config + "/tentacle/tentacle.yaml",
                    readTargets(config + "/tentacle/curl.csv", {"tip"}),
                    {},
                    16,
                    {}});
  scenes.push_back({"trunk_self", trunk, circle, {}, 8, {}});
  scenes.back().self = true;
  return scenes;
}

}  // namespace sinew
