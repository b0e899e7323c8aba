#include "sinew/inverse/contact_warnings.h"

#include <algorithm>
#include <sstream>

#include "sinew/fem/fem_model.h"
#include "sinew/mesh/embedding.h"

namespace sinew {
namespace {

constexpr double kOverlap = 1e-6;    // m of depth that count
constexpr double kManyElements = 3;  // edges of a triangle, beyond which everything is near everything

double calcRestDepth(const RobotModel& robot, const Obstacle& obstacle) {
  double depth = 0;
  for (const int node : robot.surface().nodes) {
    if (robot.fem().freeIndex(node) < 0) continue;
    const Vec3& point = robot.mesh().nodes[static_cast<std::size_t>(node)];
    for (const Obstacle::Part& part : obstacle.parts) {
      depth = std::max(depth, -part.shape.calcDistance((obstacle.pose * part.origin).inverse() * point).distance);
    }
  }
  return depth;
}

bool liesInside(const PointLocator& locator, const Obstacle& obstacle) {
  return std::any_of(obstacle.parts.begin(), obstacle.parts.end(), [&](const Obstacle::Part& part) {
    if (part.shape.kind() == ObstacleShape::Kind::kPlane) return false;
    return locator.locate((obstacle.pose * part.origin).translation()).distance == 0;
  });
}

double calcMedianEdge(const RobotModel& robot) {
  std::vector<double> edges;
  const std::vector<Vec3>& nodes = robot.mesh().nodes;
  for (const auto& t : robot.surface().triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const auto a = static_cast<std::size_t>(t[k]), b = static_cast<std::size_t>(t[(k + 1) % 3]);
      edges.push_back((nodes[a] - nodes[b]).norm());
    }
  }
  std::nth_element(edges.begin(), edges.begin() + static_cast<std::ptrdiff_t>(edges.size() / 2), edges.end());
  return edges[edges.size() / 2];
}

}  // namespace

std::vector<std::string> findContactWarnings(const RobotModel& robot) {
  std::vector<std::string> warnings;
  if (robot.maxContacts() == 0) return warnings;
  const std::string& file = robot.description().file;
  const PointLocator locator(robot.mesh());
  for (const Obstacle& obstacle : robot.obstacles()) {
    std::ostringstream text;
    const double depth = calcRestDepth(robot, obstacle);
    if (depth > kOverlap) {
      text << file << ": obstacles: " << obstacle.name << " reaches " << 1e3 * depth << " mm into the body at rest";
    } else if (liesInside(locator, obstacle)) {
      text << file << ": obstacles: " << obstacle.name << " lies inside the body at rest";
    }
    if (!text.str().empty()) warnings.push_back(text.str());
  }
  const double edge = calcMedianEdge(robot), alarm = robot.description().contacts.alarm_distance;
  if (alarm > kManyElements * edge) {
    std::ostringstream text;
    text << file << ": contacts.alarm_distance: " << alarm << " m is much for elements of " << edge
         << " m: most of what is watched never touches";
    warnings.push_back(text.str());
  }
  return warnings;
}

}  // namespace sinew
