// How the stages of a cycle grow with the unknowns of the body and with contacts, on one core.
// usage: scaling_benchmark ROOT [SCENE ...]; scenes are scaling_dofs and scaling_contacts, ROOT the project's folder.
// scaling_dofs: a bar of eight cables whose tip runs in circles, without contacts, cut into finer and finer cells.
// scaling_contacts: the scene trunk_contact with three times the rollers, of whose contacts only the nearest are kept.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <string>
#include <vector>

#include "measuring.h"
#include "mesh/bar_mesh.h"
#include "robot_scene.h"
#include "sinew/robot/robot_description.h"
#include "timed_robot.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad

void time(const RobotScene& scene, const std::shared_ptr<const RobotModel>& robot) {
  StageSamples samples;
  timeController(scene, robot, samples);
  samples.print(scene.name, *robot, scene.thesis);
}

constexpr double kWidth = 0.036, kLength = 0.2;  // m, along z, about the trunk's size
constexpr int kSlenderness = 11;                 // cells along it for one across

CableDescription makeCable(double angle, double length) {
  const Vec3 side = 0.35 * kWidth * Vec3(std::cos(angle), std::sin(angle), 0);
  CableDescription cable;
  cable.name = "cable_" + std::to_string(std::lround(360 * angle / kTurn)) + (length < kLength ? "_middle" : "_tip");
  cable.pull_point = side;
  for (int point = 1; point <= 8; ++point) cable.via_points.push_back(side + 0.95 * length * point / 8 * Vec3::UnitZ());
  cable.displacement = {-0.03, 0.06, 0.045};
  cable.tension = {0, 20, kUnlimited};
  return cable;
}

RobotDescription makeBar() {
  RobotDescription robot;
  robot.name = robot.file = robot.mesh_file = "bar";
  robot.gravity = Vec3(0, 0, 9.81);
  robot.materials.emplace_back();
  robot.materials[0].young_modulus = 250e3;
  robot.materials[0].poisson_ratio = 0.45;
  robot.materials[0].density = 1080;
  robot.fixed.boxes.push_back({Vec3(-1, -1, -1), Vec3(1, 1, 1e-6)});
  for (int quarter = 0; quarter < 4; ++quarter) {
    robot.cables.push_back(makeCable(kTurn * quarter / 4, kLength));
    robot.cables.push_back(makeCable(kTurn * (quarter + 0.5) / 4, kLength / 2));
  }
  robot.effectors.resize(2);
  robot.effectors[0].name = "tip";
  robot.effectors[0].point = kLength * Vec3::UnitZ();
  robot.effectors[1].name = "middle";
  robot.effectors[1].point = kLength / 2 * Vec3::UnitZ();
  return robot;
}

TetMesh makeMesh(int cells) {
  TetMesh mesh = makeBarMesh(Vec3(kWidth, kWidth, kLength), cells, cells, kSlenderness * cells);
  for (Vec3& node : mesh.nodes) node -= Vec3(kWidth / 2, kWidth / 2, 0);
  return mesh;
}

void runDofs(const std::string&) {
  RobotScene scene;
  scene.name = "scaling_dofs";
  scene.lead_in = 0.3;
  scene.duration = 0.5;
  scene.target = [](double seconds) -> VecX {
    const double angle = kTurn * seconds / 8;
    return Vec3(0.01 * std::sin(angle), 0.01 * (1 - std::cos(angle)), 0.199);
  };
  for (const int cells : {2, 3, 4, 5, 6, 7}) {
    time(scene, std::make_shared<const RobotModel>(makeBar(), makeMesh(cells)));
  }
}

constexpr double kBetween = 0.52;  // rad from each roller to those that are added beside it

void addRollers(ObstacleDescription& cradle) {
  const std::vector<ObstacleGeometry> rollers = cradle.geometries;
  for (const double angle : {-kBetween, kBetween}) {
    for (ObstacleGeometry roller : rollers) {
      roller.origin = Pose(Eigen::AngleAxisd(angle, Vec3::UnitZ())) * roller.origin;
      cradle.geometries.push_back(roller);
    }
  }
}

void runContacts(const std::string& root) {
  const std::vector<RobotScene> scenes = makeRobotScenes(root);
  RobotScene scene =
      *std::find_if(scenes.begin(), scenes.end(), [](const RobotScene& each) { return each.name == "trunk_contact"; });
  scene.name = "scaling_contacts";
  scene.duration = 2;
  scene.thesis.clear();
  RobotDescription description = readRobotDescription(scene.file);
  addRollers(description.obstacles.front());
  for (const int contacts : {150, 125, 100, 80, 60, 40, 20, 10}) {
    description.contacts.max_contacts = contacts;
    time(scene, std::make_shared<const RobotModel>(description));
  }
  description.obstacles.clear();
  time(scene, std::make_shared<const RobotModel>(description));
}

int runAll(const std::string& root, const std::vector<std::string>& names) {
  struct Series {
    std::string name;
    void (*run)(const std::string&);
  };
  const std::vector<Series> all = {{"scaling_dofs", runDofs}, {"scaling_contacts", runContacts}};
  for (const std::string& name : names) {
    if (std::any_of(all.begin(), all.end(), [&](const Series& series) { return series.name == name; })) continue;
    std::fprintf(stderr, "no scene %s; there are: scaling_dofs scaling_contacts\n", name.c_str());
    return 2;
  }
  for (const Series& series : all) {
    if (names.empty() || std::find(names.begin(), names.end(), series.name) != names.end()) series.run(root);
  }
  return 0;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: scaling_benchmark ROOT [SCENE ...]\n");
    return 2;
  }
  try {
    sinew::pinToOneCore();
    return sinew::runAll(argv[1], std::vector<std::string>(argv + 2, argv + argc));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "scaling_benchmark: %s\n", error.what());
    return 1;
  }
}
