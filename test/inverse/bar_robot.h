#pragma once

#include <memory>

#include "mesh/bar_mesh.h"
#include "sinew/inverse/robot_model.h"

namespace sinew {

inline TetMesh makeBarRobotMesh() {
  return makeBarMesh(Vec3(0.1, 0.02, 0.02), 8, 2, 2);
}

/// A bar along x, clamped at x = 0, with a cable along each long edge: cheap enough for dense algebra.
inline RobotDescription makeBarDescription() {
  RobotDescription robot;
  robot.name = "bar";
  robot.file = "bar.yaml";
  robot.mesh_file = "bar.msh";
  robot.gravity = Vec3(0, 0, -9.81);
  robot.materials.emplace_back();
  robot.materials[0].young_modulus = 2e5;
  robot.materials[0].poisson_ratio = 0.3;
  robot.materials[0].density = 1000;
  robot.fixed.boxes.push_back({Vec3(-1, -1, -1), Vec3(1e-6, 1, 1)});
  for (const Vec3& edge :
       {Vec3(0, 0.002, 0.002), Vec3(0, 0.018, 0.002), Vec3(0, 0.002, 0.018), Vec3(0, 0.018, 0.018)}) {
    CableDescription cable;
    cable.name = "cable_" + std::to_string(robot.cables.size() + 1);
    cable.pull_point = edge;
    for (double x : {0.03, 0.06, 0.095}) cable.via_points.push_back(edge + Vec3(x, 0, 0));
    cable.displacement = {-0.02, 0.03, 0.2};
    cable.tension = {0, 10, kUnlimited};
    robot.cables.push_back(cable);
  }
  robot.effectors.emplace_back();
  robot.effectors[0].name = "tip";
  robot.effectors[0].point = Vec3(0.1, 0.01, 0.01);
  return robot;
}

inline std::shared_ptr<const RobotModel> makeBarRobot(const RobotDescription& description = makeBarDescription()) {
  return std::make_shared<const RobotModel>(description, makeBarRobotMesh());
}

}  // namespace sinew
