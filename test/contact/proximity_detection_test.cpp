#include "sinew/contact/proximity_detection.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "check_line.h"
#include "contact/shapes.h"
#include "sinew/common/config_error.h"
#include "sinew/mesh/read_mesh.h"
#include "solver/allocation_count.h"

namespace sinew {
namespace {

constexpr int kMaxRows = 400;

std::vector<ObstacleShape> makeObstacles() {
  const TriangleMesh wedge = makeTetrahedron(0.04);
  return {ObstacleShape::makePlane(), ObstacleShape::makeSphere(0.02), ObstacleShape::makeBox(Vec3(0.01, 0.02, 0.03)),
          ObstacleShape::makeCylinder(0.015, 0.05), ObstacleShape::makeMesh(wedge)};
}

std::vector<TriangleMesh> makeBodies() {
  return {makeBar(Vec3(0.06, 0.02, 0.02), 8, 3, 3), makeBall(0.02, 2), makeFork(Vec3(0.06, 0.02, 0.04))};
}

/// A body near an obstacle.
struct Scene {
  TriangleMesh body;
  std::vector<Vec3> nodes;
  int obstacle;
  Pose pose;
};

/// Points of all triangles, `divisions` along each side.
std::vector<Vec3> calcSamples(const TriangleMesh& body, const std::vector<Vec3>& nodes, int divisions) {
  std::vector<Vec3> samples;
  for (const auto& t : body.triangles) {
    for (int i = 0; i <= divisions; ++i) {
      for (int j = 0; i + j <= divisions; ++j) {
        const double u = 1.0 * i / divisions, v = 1.0 * j / divisions;
        samples.push_back((1 - u - v) * nodes[t[0]] + u * nodes[t[1]] + v * nodes[t[2]]);
      }
    }
  }
  return samples;
}

double calcLeastDistance(const std::vector<Vec3>& samples, const ObstacleShape& shape, const Pose& pose) {
  const Pose to_shape = pose.inverse(Eigen::Isometry);
  double least = 1e300;
  for (const Vec3& x : samples) least = std::min(least, shape.calcDistance(to_shape * x).distance);
  return least;
}

/// A body brought up to an obstacle along a random line, until it is `distance` away.
Scene makeScene(Random& random, const std::vector<TriangleMesh>& bodies, const std::vector<ObstacleShape>& obstacles,
                double distance) {
  Scene scene = {bodies[random.index(static_cast<int>(bodies.size()))],
                 {},
                 random.index(static_cast<int>(obstacles.size())),
                 random.pose(0.02)};
  const ObstacleShape& shape = obstacles[scene.obstacle];
  scene.nodes = calcMoved(scene.body.vertices, random.pose(0.02));
  Vec3 away = random.direction();
  if (shape.kind() == ObstacleShape::Kind::kPlane) away = scene.pose.linear().col(2);
  const std::vector<Vec3> samples = calcSamples(scene.body, scene.nodes, 3);
  const TriangleMesh hull = shape.makeTriangles(24);
  const std::vector<Vec3> of_shape = calcSamples(hull, calcMoved(hull.vertices, scene.pose), 3);
  const ObstacleShape body = ObstacleShape::makeMesh({scene.nodes, scene.body.triangles});
  const auto calcDistanceAt = [&](double shift) {
    const Pose moved(Eigen::Translation3d(shift * away));
    const double to_shape = calcLeastDistance(calcMoved(samples, moved), shape, scene.pose);
    if (shape.kind() == ObstacleShape::Kind::kPlane) return to_shape;
    return std::min(to_shape, calcLeastDistance(of_shape, body, moved));
  };
  double near = 0, far = 0.3;
  for (int i = 0; i < 20; ++i) {
    const double middle = (near + far) / 2;
    (calcDistanceAt(middle) > distance ? far : near) = middle;
  }
  for (Vec3& x : scene.nodes) x += far * away;
  return scene;
}

ContactList detect(const Scene& scene, const ObstacleShape& shape, const ProximitySettings& settings) {
  ProximityDetection detection(settings, CollisionSurface(scene.body.triangles), scene.nodes, {shape}, kMaxRows);
  ContactList list(kMaxRows, 6 * kMaxRows);
  list.begin();
  detection.addObstacle(0, scene.pose, list);
  list.finish();
  return list;
}

using Field = Eigen::Matrix<double, 12, 1>;

/// u(x) = translation + gradient (x - centre) / length, all entries in m.
Vec3 calcMotion(const Field& field, const Vec3& x, const Vec3& centre, double length) {
  Mat3 gradient;
  gradient << field.segment<3>(3), field.segment<3>(6), field.segment<3>(9);
  return field.head<3>() + gradient * (x - centre) / length;
}

/// The least change of an affine motion that satisfies every row, by projected Gauss-Seidel.
Field enforce(const ContactList& list, const std::vector<Vec3>& nodes, const Vec3& centre, double length, Field field) {
  std::vector<Field> rows(list.size(), Field::Zero());
  VecX force = VecX::Zero(list.size());
  for (int i = 0; i < list.size(); ++i) {
    for (int k = 0; k < list.row(i).entries; ++k) {
      const ContactEntry& entry = list.entries(i)[k];
      const Vec3 arm = (nodes[entry.node] - centre) / length;
      rows[i].head<3>() += entry.gradient;
      for (int c = 0; c < 3; ++c) rows[i].segment<3>(3 + 3 * c) += arm[c] * entry.gradient;
    }
  }
  for (int sweep = 0; sweep < 3000; ++sweep) {
    double change = 0;
    for (int i = 0; i < list.size(); ++i) {
      const double gap = list.row(i).gap + rows[i].dot(field);
      const double next = std::max(0.0, force[i] - gap / rows[i].squaredNorm());
      change = std::max(change, std::abs(next - force[i]));
      field += (next - force[i]) * rows[i];
      force[i] = next;
    }
    if (change < 1e-9) break;
  }
  return field;
}

TEST(ProximityDetection, EnforcedPairsLeaveNoPointTooDeepAfterOneStep) {
  Random random(2);
  const std::vector<TriangleMesh> bodies = makeBodies();
  const std::vector<ObstacleShape> obstacles = makeObstacles();
  ProximitySettings settings;
  double deepest = 0, without = 0;
  int most_rows = 0;
  for (int i = 0; i < 600; ++i) {
    const Scene scene = makeScene(random, bodies, obstacles, random.uniform(1.0, 1.5) * settings.contact_distance);
    const ContactList list = detect(scene, obstacles[scene.obstacle], settings);
    most_rows = std::max(most_rows, list.size());
    Field field;
    field.head<3>() = random.vector(2e-3);
    for (int k = 3; k < 12; ++k) field[k] = random.uniform(-1e-3, 1e-3);  // up to 1/30: rotation, shear and strain
    const Vec3 centre = scene.nodes.front();
    const auto calcDeepest = [&](const Field& motion) {
      std::vector<Vec3> moved = scene.nodes;
      for (Vec3& x : moved) x += calcMotion(motion, x, centre, 0.03);
      const double least = calcLeastDistance(calcSamples(scene.body, moved, 8), obstacles[scene.obstacle], scene.pose);
      return settings.contact_distance - least;
    };
    without = std::max(without, calcDeepest(field));
    deepest = std::max(deepest, calcDeepest(enforce(list, scene.nodes, centre, 0.03, field)));
  }
  EXPECT_GT(without, 2e-3) << "the steps do not lead into the obstacles";
  checkFigure("detection_oracle.depth_after_step", deepest, "<=", 1e-4, "m");
  std::printf("most rows %d\n", most_rows);
}

/// Gap of the row with this key after moving the nodes; NaN if it is gone.
double calcGap(const Scene& scene, const ObstacleShape& shape, const ProximitySettings& settings, std::uint64_t key) {
  const ContactList list = detect(scene, shape, settings);
  for (int i = 0; i < list.size(); ++i) {
    if (list.row(i).key == key) return list.row(i).gap;
  }
  return std::nan("");
}

TEST(ProximityDetection, GradientsAreDifferencesOfTheGap) {
  Random random(3);
  const std::vector<TriangleMesh> bodies = makeBodies();
  const std::vector<ObstacleShape> obstacles = makeObstacles();
  const ProximitySettings settings;
  constexpr double kStep = 1e-7;
  double error = 0;
  int compared = 0;
  for (int i = 0; i < 150; ++i) {
    const Scene scene = makeScene(random, bodies, obstacles, 2e-3);
    const ObstacleShape& shape = obstacles[scene.obstacle];
    const ContactList list = detect(scene, shape, settings);
    if (list.size() == 0) continue;
    const int chosen = random.index(list.size());
    Scene forward = scene, backward = scene;
    double expected = 0;
    for (int k = 0; k < list.row(chosen).entries; ++k) {
      const ContactEntry& entry = list.entries(chosen)[k];
      const Vec3 step = random.direction();
      forward.nodes[entry.node] += kStep * step;
      backward.nodes[entry.node] -= kStep * step;
      expected += entry.gradient.dot(step);
    }
    const std::uint64_t key = list.row(chosen).key;
    const double difference =
        (calcGap(forward, shape, settings, key) - calcGap(backward, shape, settings, key)) / (2 * kStep);
    if (std::isnan(difference)) continue;  // the pair is at the limit of its features
    error = std::max(error, std::abs(difference - expected));
    ++compared;
  }
  EXPECT_GT(compared, 100);
  checkFigure("detection_oracle.gradient", error, "<=", 1e-5, "m/m");
}

struct Trunk {
  TetMesh mesh = readMesh(SINEW_SOURCE_DIR "/config/trunk/trunk.vtk", 1.0);
  CollisionSurface topology{makeBoundarySurface(mesh).triangles};
};

/// A cylinder across the trunk, 1.5 mm from its side at half its height.
Pose makeCylinderPose(const Trunk& trunk, double radius) {
  double side = 0;
  for (const Vec3& x : trunk.mesh.nodes) {
    if (std::abs(x.z() - 0.1) < radius) side = std::max(side, x.x());
  }
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitX()).toRotationMatrix();
  pose.translation() = Vec3(side + radius + 1.5e-3, 0.003, 0.1);
  return pose;
}

std::vector<std::uint64_t> keysOf(const ContactList& list) {
  std::vector<std::uint64_t> keys;
  for (int i = 0; i < list.size(); ++i) keys.push_back(list.row(i).key);
  return keys;
}

TEST(ProximityDetection, OfATrunkInPlaceGivesTheSameRowsEveryCycle) {
  const Trunk trunk;
  const std::vector<ObstacleShape> obstacles = {ObstacleShape::makeCylinder(0.02, 0.2),
                                                ObstacleShape::makeBox(Vec3(0.02, 0.02, 0.1))};
  ProximityDetection detection(ProximitySettings(), trunk.topology, trunk.mesh.nodes, obstacles, kMaxRows);
  ContactList list(kMaxRows, 6 * kMaxRows);
  const RegionPairs everywhere;
  const Pose pose = makeCylinderPose(trunk, 0.02);
  const auto cycle = [&](const std::vector<Vec3>& nodes) {
    list.begin();
    detection.update(nodes);
    detection.addObstacle(0, pose, list);
    detection.addObstacle(1, pose, list);
    detection.addSelf(everywhere, list);
    list.finish();
  };
  cycle(trunk.mesh.nodes);
  const std::vector<std::uint64_t> keys = keysOf(list);
  const double gap = list.row(0).gap;
  ASSERT_GT(keys.size(), 4u);
  EXPECT_LT(keys.size(), 80u);
  EXPECT_TRUE(std::is_sorted(keys.begin(), keys.end()));
  Random random(4);
  std::vector<Vec3> shaken = trunk.mesh.nodes;
  int changed = 0;
  const long before = allocationCount();
  for (int i = 0; i < 1000; ++i) {
    cycle(trunk.mesh.nodes);
    const bool is_same = list.size() == static_cast<int>(keys.size()) && list.row(0).gap == gap;
    if (!is_same) ++changed;
  }
  if (countsAllocations()) {
    EXPECT_EQ(allocationCount(), before);
  }
  for (int i = 0; i < 1000; ++i) {
    for (std::size_t n = 0; n < shaken.size(); ++n) shaken[n] = trunk.mesh.nodes[n] + random.vector(1e-9);
    cycle(shaken);
    if (keysOf(list) != keys) ++changed;
  }
  checkFigure("detection_oracle.changed_lists", changed, "<=", 0, "of 2000");
  std::printf("rows %zu\n", keys.size());
}

TEST(ProximityDetection, OfAForkFindsItsProngsWhenTheyCloseAndNothingBefore) {
  const TriangleMesh fork = makeFork(Vec3(0.03, 0.01, 0.04));
  const std::vector<Vec3>& rest = fork.vertices;
  ProximitySettings settings;
  ProximityDetection detection(settings, CollisionSurface(fork.triangles), rest, {}, kMaxRows);
  ContactList list(kMaxRows, 6 * kMaxRows);
  const auto cycle = [&](double shift) {
    std::vector<Vec3> nodes = rest;
    for (Vec3& x : nodes) {
      if (x.z() > 0.03) x.x() += x.x() < 0.015 ? shift : -shift;
    }
    list.begin();
    detection.update(nodes);
    detection.addSelf(RegionPairs(), list);
    list.finish();
  };
  cycle(0);
  EXPECT_EQ(list.size(), 0);
  for (const double open : {3e-3, 0.5e-3, -0.5e-3}) {
    cycle((0.01 - open) / 2);
    ASSERT_GT(list.size(), 0) << open;
    double least = 1;
    for (int i = 0; i < list.size(); ++i) {
      least = std::min(least, list.row(i).gap);
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < list.row(i).entries; ++k) sum += list.entries(i)[k].gradient;
      EXPECT_LT(sum.norm(), 1e-9) << "a motion of the whole body must not change a gap of self-contact";
    }
    EXPECT_NEAR(least, open - settings.contact_distance, 1e-4);
    EXPECT_GT(std::abs(list.row(0).normal.x()), 0.9);
  }
}

TEST(ProximityDetection, OfTwoSoftBodiesHasEntriesOnBoth) {
  const TriangleMesh bar = makeBar(Vec3(0.02, 0.02, 0.02), 2, 2, 2);
  std::vector<Vec3> above = bar.vertices;
  for (Vec3& x : above) x += Vec3(0.003, 0.004, 0.022);
  const CollisionSurface topology(bar.triangles);
  ProximityDetection detection(ProximitySettings(), topology, above, {}, kMaxRows);
  ContactList list(kMaxRows, 6 * kMaxRows);
  EXPECT_FALSE(detection.addOther(MovingSurface(topology, bar.vertices), list)) << "without room";
  detection.reserveOther(topology.vertices());
  list.begin();
  EXPECT_TRUE(detection.addOther(MovingSurface(topology, bar.vertices), list));
  list.finish();
  ASSERT_GT(list.size(), 3);
  for (int i = 0; i < list.size(); ++i) {
    EXPECT_NEAR(list.row(i).gap, 0.001, 1e-12);
    EXPECT_LT((list.row(i).normal - Vec3::UnitZ()).norm(), 1e-12);
    Vec3 sums[2] = {Vec3::Zero(), Vec3::Zero()};
    for (int k = 0; k < list.row(i).entries; ++k) sums[list.entries(i)[k].surface] += list.entries(i)[k].gradient;
    EXPECT_LT((sums[0] - Vec3::UnitZ()).norm(), 1e-9);
    EXPECT_LT((sums[1] + Vec3::UnitZ()).norm(), 1e-9);
  }
}

TEST(ProximityDetection, RefusesSettingsThatMakeNoSense) {
  const TriangleMesh bar = makeBar(Vec3(0.02, 0.02, 0.02), 1, 1, 1);
  ProximitySettings settings;
  settings.alarm_distance = settings.contact_distance / 2;
  EXPECT_THROW(ProximityDetection(settings, CollisionSurface(bar.triangles), bar.vertices, {}, 10), ConfigError);
}

}  // namespace
}  // namespace sinew
