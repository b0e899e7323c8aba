#include "visualization_node_obstacles.h"

#include <algorithm>
#include <utility>

#include "ros_conversions.h"

namespace sinew {
namespace {

using visualization_msgs::Marker;

const Colour kObstacleColour(0.50, 0.55, 0.62, 1.0);
const Colour kPlaneColour(0.62, 0.66, 0.72, 0.35);
const Colour kDotColour(0.25, 0.28, 0.33, 0.9);
const Colour kForceColour(0.80, 0.10, 0.55, 1.0);

constexpr int kDivisions = 32;
constexpr double kGrowth = 1.01;      // 1, so that the visual of a URDF in the same place does not shine through
constexpr double kLeastForce = 1e-3;  // N below which there is no arrow

Mat3 calcCorners(const TriangleMesh& mesh, const CollisionSurface::Triangle& triangle, const Pose& pose) {
  Mat3 corners;
  for (int k = 0; k < 3; ++k) {
    corners.col(k) = pose * (kGrowth * mesh.vertices[static_cast<std::size_t>(triangle[static_cast<std::size_t>(k)])]);
  }
  return corners;
}

Marker makeTriangleMarker(const TriangleMesh& mesh, const Pose& pose, const Colour& colour, const Light& light,
                          Marker marker) {
  for (const auto& triangle : mesh.triangles) {
    const Mat3 corners = calcCorners(mesh, triangle, pose);
    const Vec3 normal = (corners.col(1) - corners.col(0)).cross(corners.col(2) - corners.col(0)).normalized();
    const std_msgs::ColorRGBA shade = toRgba(light.calcShade(normal, colour));
    for (int k = 0; k < 3; ++k) {
      marker.points.push_back(toPoint(corners.col(k)));
      marker.colors.push_back(shade);
    }
  }
  return marker;
}

}  // namespace

ObstacleDrawing::ObstacleDrawing(const std::vector<Obstacle>& obstacles) {
  for (const Obstacle& obstacle : obstacles) {
    for (const Obstacle::Part& part : obstacle.parts) parts_.push_back({obstacle.name, part.shape, part.origin});
  }
}

void ObstacleDrawing::add(const TrackedObstacles& where, const Light& light, double plane_size,
                          visualization_msgs::MarkerArray& markers) const {
  for (std::size_t i = 0; i < parts_.size(); ++i) {
    const Part& part = parts_[i];
    const auto found = std::find(where.name.begin(), where.name.end(), part.obstacle);
    const auto index = static_cast<std::size_t>(found - where.name.begin());
    if (index >= where.pose.size() || index >= where.present.size() || !where.present[index]) continue;
    const bool plane = part.shape.kind() == ObstacleShape::Kind::kPlane;
    Marker marker = makeMarker(where.header, "obstacles", static_cast<int>(i), Marker::TRIANGLE_LIST);
    marker.lifetime = ros::Duration(0.5);
    markers.markers.push_back(makeTriangleMarker(part.shape.makeTriangles(kDivisions, plane_size),
                                                 toPose(where.pose[index]) * part.origin,
                                                 plane ? kPlaneColour : kObstacleColour, light, std::move(marker)));
  }
}

void addContacts(const ContactArray& contacts, const ContactStyle& style, visualization_msgs::MarkerArray& markers) {
  Marker dots = makeMarker(contacts.header, "contact_points", 0, Marker::SPHERE_LIST);
  dots.scale.x = dots.scale.y = dots.scale.z = 2 * style.dot_radius;
  dots.color = toRgba(kDotColour);
  dots.lifetime = ros::Duration(0.2);
  int id = 0;
  for (const Contact& contact : contacts.contacts) {
    dots.points.push_back(contact.point);
    if (!(contact.force > kLeastForce)) continue;
    const double length = std::min(style.max_length, style.force_scale * contact.force);
    const Vec3 normal(contact.normal.x, contact.normal.y, contact.normal.z);
    Marker arrow = makeMarker(contacts.header, "contact_forces", id++, Marker::ARROW);
    arrow.points = {contact.point, toPoint(toVec3(contact.point) + length * normal)};
    arrow.scale.x = 1.4 * style.dot_radius;  // diameter of the shaft
    arrow.scale.y = 3.2 * style.dot_radius;  // of the head
    arrow.scale.z = std::min(4 * style.dot_radius, 0.5 * length);
    arrow.color = toRgba(kForceColour);
    arrow.lifetime = ros::Duration(0.2);
    markers.markers.push_back(std::move(arrow));
  }
  if (!dots.points.empty()) markers.markers.push_back(std::move(dots));
}

}  // namespace sinew
