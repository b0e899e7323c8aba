#include <gtest/gtest.h>

#include <limits>

#include "visualization_node_drawing.h"
#include "visualization_node_workspace.h"

namespace sinew {
namespace {

using visualization_msgs::Marker;
using visualization_msgs::MarkerArray;

geometry_msgs::Point32 makePoint(float x, float y, float z) {
  geometry_msgs::Point32 point;
  point.x = x;
  point.y = y;
  point.z = z;
  return point;
}

/// A tetrahedron with one cable along x that carries half of its greatest tension.
BodyState makeBody() {
  BodyState body;
  body.header.frame_id = "base";
  body.vertices = {makePoint(0, 0, 0), makePoint(1, 0, 0), makePoint(0, 1, 0), makePoint(0, 0, 1)};
  body.triangles = {0, 2, 1, 0, 1, 3, 1, 2, 3, 0, 3, 2};
  body.cable = {"cable"};
  body.cable_size = {3};
  body.cable_points = {makePoint(0, 0, 0), makePoint(0.5, 0, 0), makePoint(1, 0, 0)};
  body.cable_tension = {5};
  body.cable_tension_max = {10};
  return body;
}

const Marker* find(const MarkerArray& markers, const std::string& name) {
  for (const Marker& marker : markers.markers) {
    if (marker.ns == name) return &marker;
  }
  return nullptr;
}

MarkerArray drawBody(const BodyState& body) {
  MarkerArray markers;
  const BodyStyle style{"", Colour(0.8, 0.6, 0.4, 0.5), Colour(0, 0, 0, 0.2), true};
  addBody(body, style, Light(), calcExtent(body), markers);
  return markers;
}

TEST(Drawing, TellsConsistentBodies) {
  EXPECT_TRUE(isConsistent(makeBody()));
  BodyState body = makeBody();
  body.triangles.back() = 4;
  EXPECT_FALSE(isConsistent(body));
  body = makeBody();
  body.triangles.pop_back();
  EXPECT_FALSE(isConsistent(body));
  body = makeBody();
  body.cable_size[0] = 4;
  EXPECT_FALSE(isConsistent(body));
  body = makeBody();
  body.cable_tension.clear();
  EXPECT_FALSE(isConsistent(body));
  body = makeBody();
  body.header.frame_id.clear();
  EXPECT_FALSE(isConsistent(body));
}

TEST(Drawing, DrawsEveryTriangleEdgeAndCableOnce) {
  const MarkerArray markers = drawBody(makeBody());
  const Marker* body = find(markers, "body");
  ASSERT_TRUE(body);
  EXPECT_EQ(12u, body->points.size());
  EXPECT_EQ(body->points.size(), body->colors.size());
  EXPECT_EQ("base", body->header.frame_id);
  EXPECT_EQ(2u * 6u, find(markers, "edges")->points.size());
  EXPECT_EQ(1u, find(markers, "pull_points")->points.size());
  const Marker* cables = find(markers, "cables");
  ASSERT_TRUE(cables);
  EXPECT_EQ(0u, cables->points.size() % 6);
  for (const auto& point : cables->points) {
    EXPECT_NEAR(std::hypot(cables->points[0].y, cables->points[0].z), std::hypot(point.y, point.z), 1e-9);
  }
}

TEST(Drawing, TensionGoesFromBlueToRed) {
  const Colour slack = calcTensionColour(0), most = calcTensionColour(1);
  EXPECT_GT(slack[2], 2 * slack[0]);
  EXPECT_GT(most[0], 2 * most[2]);
  EXPECT_EQ(most, calcTensionColour(7));
  EXPECT_EQ(slack, calcTensionColour(-1));

  BodyState body = makeBody();
  body.cable_tension_max[0] = std::numeric_limits<double>::infinity();
  const MarkerArray unlimited = drawBody(body);
  EXPECT_FLOAT_EQ(static_cast<float>(slack[2]), find(unlimited, "pull_points")->colors[0].b);
}

TEST(Drawing, LightComesFromTheLampInAnyFrame) {
  Light light;
  const Colour base(0.5, 0.5, 0.5, 0.7);
  EXPECT_GT(light.calcShade(light.key, base)[0], light.calcShade(-light.key, base)[0]);
  EXPECT_EQ(0.7, light.calcShade(light.key, base)[3]);
  const Mat3 turned = Eigen::AngleAxisd(1.1, Vec3(1, 2, 3).normalized()).toRotationMatrix();
  const Vec3 normal = Vec3(0.3, -0.4, 0.5).normalized();
  EXPECT_LT(
      (light.seenFrom(turned).calcShade(turned.transpose() * normal, base) - light.calcShade(normal, base)).norm(),
      1e-12);
}

ControllerState makeController() {
  ControllerState state;
  state.header.frame_id = "base";
  state.status = ControllerState::TRACKING;
  state.effectors.resize(2);
  state.effectors[0].name = "tip";
  state.effectors[0].targeted = true;
  state.effectors[0].target.z = 2;
  state.effectors[1].name = "free";
  return state;
}

TEST(Drawing, DrawsTargetsOnlyWhereThereAreAny) {
  ControllerState state = makeController();
  MarkerArray markers;
  addEffectors(state, 1, markers);
  EXPECT_EQ(2u, find(markers, "effectors")->points.size());
  EXPECT_EQ(1u, find(markers, "targets")->points.size());
  EXPECT_EQ(2u, find(markers, "effector_errors")->points.size());
  markers.markers.clear();
  state.status = ControllerState::DISABLED;
  addEffectors(state, 1, markers);
  EXPECT_FALSE(find(markers, "targets"));
}

TEST(Drawing, NamesTheLimitsReached) {
  ControllerState state = makeController();
  state.limits.resize(2);
  state.limits[0].actuator = state.limits[1].actuator = "cable";
  state.limits[0].kind = ActiveLimit::EFFORT_MAX;
  state.limits[1].kind = ActiveLimit::EFFORT_MIN;
  MarkerArray markers;
  addLimits(state, makeBody(), 1, markers);
  ASSERT_TRUE(find(markers, "limit_texts"));
  EXPECT_NE(std::string::npos, find(markers, "limit_texts")->text.find("cable: tension limit"));
  EXPECT_EQ(1u, find(markers, "limit_heads")->points.size()) << "a slack cable is no trouble";
}

TEST(Drawing, ATrailForgetsAndRestarts) {
  Trail trail(1.0, Colour::Ones());
  MarkerArray markers;
  for (int i = 0; i <= 30; ++i) trail.add(ros::Time(100 + 0.1 * i), Vec3(i, 0, 0));
  trail.draw(std_msgs::Header(), "trail", 0, 0.01, markers);
  ASSERT_EQ(1u, markers.markers.size());
  EXPECT_NEAR(11, static_cast<double>(markers.markers[0].points.size()), 1);
  EXPECT_LT(markers.markers[0].colors.front().a, markers.markers[0].colors.back().a);
  trail.add(ros::Time(5), Vec3::Zero());
  markers.markers.clear();
  trail.draw(std_msgs::Header(), "trail", 0, 0.01, markers);
  EXPECT_TRUE(markers.markers.empty());
}

TEST(Workspace, ClampsToTheBoxAndTheSphere) {
  Workspace workspace;
  EXPECT_EQ(Vec3(5, 6, 7), workspace.calcClamped(Vec3(5, 6, 7)));
  workspace.centre = Vec3(0, 0, 0.2);
  workspace.radius = 0.1;
  EXPECT_LT((workspace.calcClamped(Vec3(0, 0, 1)) - Vec3(0, 0, 0.3)).norm(), 1e-12);
  EXPECT_EQ(Vec3(0.01, 0, 0.2), workspace.calcClamped(Vec3(0.01, 0, 0.2)));
  workspace.box = Eigen::AlignedBox3d(Vec3(-1, -1, 0), Vec3(1, 1, 0.25));
  const Vec3 clamped = workspace.calcClamped(Vec3(3, 4, 9));
  EXPECT_LE((clamped - workspace.centre).norm(), 0.1 + 1e-12);
  EXPECT_TRUE(workspace.box.contains(clamped));
}

}  // namespace
}  // namespace sinew
