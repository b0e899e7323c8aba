#include "sinew/contact/volume_detection.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "check_line.h"
#include "contact/shapes.h"
#include "sinew/common/config_error.h"
#include "solver/allocation_count.h"

namespace sinew {
namespace {

constexpr int kMaxRegions = 16;

struct Overlap {
  Overlap(const TriangleMesh& body, const ObstacleShape& shape, const VolumeSettings& settings)
      : surface(CollisionSurface(body.triangles), body.vertices),
        detection(settings, surface.topology(), {shape}, kMaxRegions) {}

  void update(const std::vector<Vec3>& nodes, const Pose& pose) {
    surface.update(nodes);
    list.begin();
    EXPECT_TRUE(detection.addObstacle(surface, 0, pose, list));
    list.finish();
  }
  double volume() const {
    double sum = 0;
    for (const VolumeRegion& region : detection.regions()) sum += region.volume;
    return sum;
  }

  MovingSurface surface;
  VolumeDetection detection;
  ContactList list{kMaxRegions, 20000};
};

/// Volume of a box's part (own frame) inside a shape grown as VolumeDetection grows it, by columns of `n` x `n` lines
/// through the box, each measured exactly.
double calcBoxVolume(const Vec3& size, const Pose& box, const ObstacleShape& shape, double dilation, const Pose& pose,
                     int n) {
  const Pose to_shape = pose.inverse(Eigen::Isometry) * box;
  double sum = 0;
  for (int i = 0; i < n; ++i) {
    for (int j = 0; j < n; ++j) {
      double enter, leave;
      const Vec3 start(size.x() * (i + 0.5) / n, size.y() * (j + 0.5) / n, 0);
      if (!shape.calcChord(to_shape * start, to_shape.linear().col(2), dilation, &enter, &leave)) continue;
      sum += std::max(0.0, std::min(leave, size.z()) - std::max(enter, 0.0));
    }
  }
  return sum * size.x() * size.y() / (n * n);
}

TEST(VolumeDetection, OfBoxesInLineWithThePixelsIsExact) {
  VolumeSettings settings;
  const Vec3 size(0.04, 0.03, 0.02);
  const TriangleMesh body = makeBar(size, 4, 3, 2);
  Overlap run(body, ObstacleShape::makeBox(Vec3(0.01, 0.008, 0.01)), settings);
  Pose pose = Pose::Identity();
  double error = 0;
  for (const double distance : {1.2e-3, 1e-3, 0.0, -2e-3}) {
    pose.translation() = Vec3(0.02, 0.015, size.z() + 0.01 + distance);
    run.update(body.vertices, pose);
    ASSERT_EQ(run.list.size(), 1) << distance;
    const ContactRow& row = run.list.row(0);
    const Vec3 overlap(0.02 + 2 * settings.dilation, 0.016 + 2 * settings.dilation, settings.dilation - distance);
    error = std::max(error, std::abs(run.volume() / overlap.prod() - 1));
    EXPECT_NEAR(row.gap, distance - settings.contact_distance, 1e-12);
    EXPECT_LT((row.normal + Vec3::UnitZ()).norm(), 1e-12);
    EXPECT_NEAR((row.point - row.other_point).dot(row.normal), distance, 1e-12);
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < row.entries; ++k) sum += run.list.entries(0)[k].gradient;
    EXPECT_LT((sum - row.normal).norm(), 1e-12);
  }
  checkFigure("volume_contacts.aligned_boxes", error, "<=", 1e-12, "ratio");
}

TEST(VolumeDetection, IsWithinAPercentAtSixtyFourPixels) {
  Random random(5);
  const Vec3 size(0.04, 0.03, 0.02);
  const TriangleMesh body = makeBar(size, 3, 2, 2);
  const std::vector<ObstacleShape> shapes = {ObstacleShape::makeBox(Vec3(0.01, 0.015, 0.02)),
                                             ObstacleShape::makeSphere(0.015), ObstacleShape::makeCylinder(0.01, 0.03),
                                             ObstacleShape::makePlane()};
  double worst[2] = {0, 0};
  double mean[2] = {0, 0};
  int scenes = 0;
  while (scenes < 60) {
    const ObstacleShape& shape = shapes[random.index(4)];
    const Pose pose = random.pose(0.015);
    const Pose placed = random.pose(0.015);
    const VolumeSettings settings;
    const double expected = calcBoxVolume(size, placed, shape, settings.dilation, pose, 600);
    if (expected < 0.02 * size.prod()) continue;
    ++scenes;
    for (const int k : {0, 1}) {
      VolumeSettings finer = settings;
      finer.pixels = k == 0 ? 16 : 64;
      Overlap run(body, shape, finer);
      run.update(calcMoved(body.vertices, placed), pose);
      const double error = std::abs(run.volume() / expected - 1);
      worst[k] = std::max(worst[k], error);
      mean[k] += error / 60;
    }
  }
  checkFigure("volume_contacts.volume", worst[1], "<=", 0.01, "ratio");
  checkFigure("volume_contacts.finer_over_coarser", mean[1] / mean[0], "<=", 0.5, "ratio");
}

TEST(VolumeDetection, OfAMeshIsThatOfTheSameShape) {
  Random random(6);
  const Vec3 size(0.04, 0.03, 0.02);
  const TriangleMesh body = makeBar(size, 3, 2, 2);
  const ObstacleShape box = ObstacleShape::makeBox(Vec3(0.01, 0.015, 0.02));
  const ObstacleShape mesh = ObstacleShape::makeMesh(box.makeTriangles(0));
  Overlap by_box(body, box, VolumeSettings()), by_mesh(body, mesh, VolumeSettings());
  double worst = 0;
  for (int i = 0; i < 40; ++i) {
    const Pose pose = random.pose(0.02);
    by_box.update(body.vertices, pose);
    by_mesh.update(body.vertices, pose);
    if (by_box.volume() > 1e-7) worst = std::max(worst, std::abs(by_mesh.volume() / by_box.volume() - 1));
  }
  checkFigure("volume_contacts.mesh_against_box", worst, "<=", 0.01, "ratio");
}

/// Along each axis the gradient is that of the view along it; the volume mixes the views by the normal. With the normal
/// along an axis, V is one view's, and moving nodes along that axis changes it by the gradient exactly, but for pixels
/// whose ray passes from one triangle to the next.
TEST(VolumeDetection, GradientIsTheDifferenceOfTheVolume) {
  Random random(7);
  const Vec3 size(0.04, 0.03, 0.02);
  const TriangleMesh body = makeBar(size, 4, 3, 2);
  VolumeSettings settings;
  settings.sharpness = 0;
  settings.dilation = 1.2 * settings.contact_distance;
  Overlap run(body, ObstacleShape::makePlane(), settings);
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(M_PI, Vec3::UnitX()).toRotationMatrix();
  pose.translation().z() = size.z() - 2e-3;
  std::vector<Vec3> nodes = body.vertices;
  for (Vec3& x : nodes) x.z() += random.uniform(-3e-4, 3e-4);
  run.update(nodes, pose);
  ASSERT_EQ(run.list.size(), 1);
  const double area = run.list.row(0).area;
  double worst = 0;
  for (int k = 0; k < run.list.row(0).entries; ++k) {
    const ContactEntry entry = run.list.entries(0)[k];
    std::vector<Vec3> moved = nodes;
    moved[entry.node].z() += 1e-6;
    Overlap forward(body, ObstacleShape::makePlane(), settings);
    forward.update(moved, pose);
    moved[entry.node].z() -= 2e-6;
    Overlap backward(body, ObstacleShape::makePlane(), settings);
    backward.update(moved, pose);
    const double difference = -(forward.volume() - backward.volume()) / 2e-6 / area;
    worst = std::max(worst, std::abs(difference - entry.gradient.z()));
  }
  checkFigure("volume_contacts.gradient", worst, "<=", 2e-3, "m/m");
}

TEST(VolumeDetection, GradientsTogetherAreTheNormal) {
  Random random(8);
  const TriangleMesh body = makeBall(0.02, 3);
  Overlap run(body, ObstacleShape::makeSphere(0.02), VolumeSettings());
  for (int i = 0; i < 30; ++i) {
    const Vec3 direction = random.direction();
    Pose pose = Pose::Identity();
    pose.translation() = 0.0395 * direction;
    run.update(body.vertices, pose);
    ASSERT_EQ(run.list.size(), 1);
    EXPECT_GT(run.list.row(0).normal.dot(-direction), 0.999);
    Vec3 sum = Vec3::Zero();
    for (int k = 0; k < run.list.row(0).entries; ++k) sum += run.list.entries(0)[k].gradient;
    EXPECT_LT((sum - run.list.row(0).normal).norm(), 1e-9);
  }
}

TEST(VolumeDetection, GivesEachConnectedPartItsRow) {
  const TriangleMesh fork = makeFork(Vec3(0.06, 0.02, 0.04));
  Overlap run(fork, ObstacleShape::makeBox(Vec3(0.05, 0.05, 0.01)), VolumeSettings());
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(0.03, 0.01, 0.04 + 0.01 + 0.5e-3);
  run.update(fork.vertices, pose);
  ASSERT_EQ(run.list.size(), 2);
  for (int i = 0; i < 2; ++i) EXPECT_NEAR(run.list.row(i).gap, -0.5e-3, 1e-12);
  EXPECT_NEAR(std::abs(run.list.row(0).point.x() - run.list.row(1).point.x()), 0.04, 1e-3);
}

TEST(VolumeDetection, HoldsOnToItsRowsAndAllocatesNothing) {
  Random random(9);
  const TriangleMesh fork = makeFork(Vec3(0.06, 0.02, 0.04));
  Overlap run(fork, ObstacleShape::makeCylinder(0.02, 0.1), VolumeSettings());
  Pose pose = Pose::Identity();
  pose.linear() = Eigen::AngleAxisd(M_PI / 2, Vec3::UnitY()).toRotationMatrix();
  pose.translation() = Vec3(0.03, 0.01, 0.04 + 0.02 + 0.5e-3);
  run.update(fork.vertices, pose);
  ASSERT_EQ(run.list.size(), 2);
  const std::uint64_t keys[2] = {run.list.row(0).key, run.list.row(1).key};
  const double gap = run.list.row(0).gap;
  std::vector<Vec3> nodes = fork.vertices;
  int changed = 0;
  const long before = allocationCount();
  for (int i = 0; i < 1000; ++i) {
    for (std::size_t n = 0; n < nodes.size(); ++n) {
      nodes[n] = fork.vertices[n] + (i % 2 == 0 ? Vec3(Vec3::Zero()) : random.vector(1e-9));
    }
    run.update(nodes, pose);
    const bool is_same = run.list.size() == 2 && run.list.row(0).key == keys[0] && run.list.row(1).key == keys[1];
    const bool is_repeated = i % 2 == 1 || (is_same && run.list.row(0).gap == gap);
    if (!is_same || !is_repeated) ++changed;
  }
  if (countsAllocations()) {
    EXPECT_EQ(allocationCount(), before);
  }
  checkFigure("volume_contacts.changed_lists", changed, "<=", 0, "of 1000");
}

TEST(VolumeDetection, KeepsARowLongerThanItWouldTakeItUp) {
  VolumeSettings settings;
  const TriangleMesh body = makeBar(Vec3(0.02, 0.02, 0.02), 2, 2, 2);
  const auto poseAt = [&](double thickness) {
    Pose pose = Pose::Identity();
    pose.linear() = Eigen::AngleAxisd(M_PI, Vec3::UnitX()).toRotationMatrix();
    pose.translation().z() = 0.02 + settings.dilation * (1 - thickness);
    return pose;
  };
  Overlap run(body, ObstacleShape::makePlane(), settings);
  const double thin = (settings.appear + settings.vanish) / 2;
  run.update(body.vertices, poseAt(thin));
  EXPECT_EQ(run.list.size(), 0);
  run.update(body.vertices, poseAt(2 * settings.appear));
  EXPECT_EQ(run.list.size(), 1);
  run.update(body.vertices, poseAt(thin));
  EXPECT_EQ(run.list.size(), 1);
  run.update(body.vertices, poseAt(settings.vanish / 2));
  EXPECT_EQ(run.list.size(), 0);
}

TEST(VolumeDetection, RefusesADilationThatLetsRoundBodiesTouch) {
  VolumeSettings settings;
  settings.dilation = 4 * settings.contact_distance;
  EXPECT_THROW(settings.check(), ConfigError);
}

}  // namespace
}  // namespace sinew
