#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "ros_conversions.h"
#include "visualization_node_obstacles.h"

namespace sinew {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

/// A box of edges 2, 4 and 6 m beside its obstacle's origin, and a plane.
std::vector<Obstacle> makeObstacles() {
  Pose beside = Pose::Identity();
  beside.translation() = Vec3(1, 0, 0);
  std::vector<Obstacle> obstacles(2);
  obstacles[0].name = "box";
  obstacles[0].parts.push_back({ObstacleShape::makeBox(Vec3(1, 2, 3)), beside});
  obstacles[1].name = "floor";
  obstacles[1].parts.push_back({ObstacleShape::makePlane(), Pose::Identity()});
  return obstacles;
}

TrackedObstacles makeWhere() {
  TrackedObstacles where;
  where.header.frame_id = "base";
  where.name = {"floor", "box"};
  where.pose.resize(2);
  for (auto& pose : where.pose) pose.orientation.w = 1;
  where.pose[1].position.z = 10;
  where.present = {true, true};
  return where;
}

Eigen::AlignedBox3d calcBounds(const Marker& marker) {
  Eigen::AlignedBox3d box;
  for (const auto& point : marker.points) box.extend(toVec3(point));
  return box;
}

TEST(ObstacleDrawing, DrawsShapesWhereTheyAre) {
  const ObstacleDrawing drawing(makeObstacles());
  MarkerArray markers;
  drawing.add(makeWhere(), Light(), 20, markers);
  ASSERT_EQ(2u, markers.markers.size());
  EXPECT_NE(markers.markers[0].id, markers.markers[1].id);
  const Marker& box = markers.markers[0];
  EXPECT_EQ("base", box.header.frame_id);
  EXPECT_EQ(36u, box.points.size());
  EXPECT_EQ(box.points.size(), box.colors.size());
  EXPECT_LT((calcBounds(box).min() - Vec3(0, -2, 7)).norm(), 0.05);
  EXPECT_LT((calcBounds(box).max() - Vec3(2, 2, 13)).norm(), 0.05);
  EXPECT_NEAR(20, calcBounds(markers.markers[1]).sizes().x(), 0.3);
}

TEST(ObstacleDrawing, LeavesOutWhatIsAbsentOrUnheardOf) {
  const ObstacleDrawing drawing(makeObstacles());
  TrackedObstacles where = makeWhere();
  where.present[0] = false;
  where.name[1] = "lamp";
  MarkerArray markers;
  drawing.add(where, Light(), 20, markers);
  EXPECT_TRUE(markers.markers.empty());
  where = makeWhere();
  where.pose.clear();
  drawing.add(where, Light(), 20, markers);
  EXPECT_TRUE(markers.markers.empty()) << "sizes that do not fit together";
}

TEST(ContactDrawing, ArrowsAreAsLongAsTheForcesUpToALimit) {
  ContactArray contacts;
  contacts.header.frame_id = "base";
  for (const double force : {0.0, 2.0, 1000.0}) {
    Contact contact;
    contact.point.x = force;
    contact.normal.z = 1;
    contact.force = force;
    contacts.contacts.push_back(contact);
  }
  MarkerArray markers;
  addContacts(contacts, ContactStyle{0.01, 0.1, 0.5}, markers);
  std::vector<double> lengths;
  for (const Marker& marker : markers.markers) {
    if (marker.type == Marker::SPHERE_LIST) {
      EXPECT_EQ(3u, marker.points.size()) << "every contact has its dot";
    } else {
      ASSERT_EQ(2u, marker.points.size());
      lengths.push_back(marker.points[1].z - marker.points[0].z);
    }
  }
  std::sort(lengths.begin(), lengths.end());
  ASSERT_EQ(2u, lengths.size());
  EXPECT_NEAR(0.2, lengths[0], 1e-12);
  EXPECT_NEAR(0.5, lengths[1], 1e-12);
}

}  // namespace
}  // namespace sinew
