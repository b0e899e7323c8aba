#pragma once

#include <vector>

#include "inverse/bar_robot.h"
#include "sinew/inverse/condensed_robot.h"
#include "sinew/inverse/contact_finder.h"

namespace sinew {

inline ObstacleDescription makeObstacleDescription(const std::string& name, const ObstacleGeometry& geometry,
                                                   const Pose& pose) {
  ObstacleDescription obstacle;
  obstacle.name = name;
  obstacle.geometries = {geometry};
  obstacle.pose = pose;
  return obstacle;
}

inline ObstacleDescription makeSphere(double radius, const Vec3& centre) {
  ObstacleGeometry sphere;
  sphere.kind = ObstacleGeometry::Kind::kSphere;
  sphere.radius = radius;
  return makeObstacleDescription("ball", sphere, Pose(Eigen::Translation3d(centre)));
}

/// A cylinder across the bar, its axis along y.
inline ObstacleDescription makeCylinder(double radius, const Vec3& centre) {
  ObstacleGeometry cylinder;
  cylinder.kind = ObstacleGeometry::Kind::kCylinder;
  cylinder.radius = radius;
  cylinder.length = 0.2;
  const Pose pose = Eigen::Translation3d(centre) * Eigen::AngleAxisd(0.5 * M_PI, Vec3::UnitX());
  return makeObstacleDescription("post", cylinder, pose);
}

/// The half space below `height`.
inline ObstacleDescription makeFloor(double height) {
  ObstacleGeometry plane;
  plane.kind = ObstacleGeometry::Kind::kPlane;
  return makeObstacleDescription("floor", plane, Pose(Eigen::Translation3d(0, 0, height)));
}

inline RobotDescription makeContactDescription(const std::vector<ObstacleDescription>& obstacles) {
  RobotDescription robot = makeBarDescription();
  robot.obstacles = obstacles;
  robot.contacts.alarm_distance = 0.005;
  robot.contacts.contact_distance = 0.001;
  robot.contacts.max_contacts = 60;
  return robot;
}

}  // namespace sinew
