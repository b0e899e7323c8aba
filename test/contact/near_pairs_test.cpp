#include "sinew/contact/near_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "contact/shapes.h"
#include "sinew/contact/surface_pairs.h"
#include "solver/allocation_count.h"

namespace sinew {
namespace {

constexpr int kMaxRows = 2000;

ProximitySettings makeSettings() {
  ProximitySettings settings;
  settings.alarm_distance = 3e-3;
  return settings;
}

/// Expects the same rows with the same numbers, to the last bit.
void expectEqual(const ContactList& found, const ContactList& expected) {
  ASSERT_EQ(found.size(), expected.size());
  ASSERT_EQ(found.dropped(), expected.dropped());
  for (int i = 0; i < found.size(); ++i) {
    const ContactRow& a = found.row(i);
    const ContactRow& b = expected.row(i);
    ASSERT_EQ(a.key, b.key);
    ASSERT_EQ(a.gap, b.gap);
    ASSERT_EQ(a.area, b.area);
    ASSERT_EQ(a.point, b.point);
    ASSERT_EQ(a.other_point, b.other_point);
    ASSERT_EQ(a.normal, b.normal);
    ASSERT_EQ(a.entries, b.entries);
    for (int k = 0; k < a.entries; ++k) {
      ASSERT_EQ(found.entries(i)[k].surface, expected.entries(i)[k].surface);
      ASSERT_EQ(found.entries(i)[k].node, expected.entries(i)[k].node);
      ASSERT_EQ(found.entries(i)[k].gradient, expected.entries(i)[k].gradient);
    }
  }
}

/// Detection with and without a list, side by side.
class Twins {
 public:
  Twins(const ProximitySettings& settings, const MovingSurface& a, const MovingSurface& b, int max_rows = kMaxRows)
      : near(settings, a, b),
        with_(settings, a.topology().vertices(), b.topology().vertices(), max_rows),
        without_(settings, a.topology().vertices(), b.topology().vertices(), max_rows),
        found_(max_rows, 6 * max_rows),
        expected_(max_rows, 6 * max_rows) {}

  void checkOwn(const MovingSurface& surface, const RegionPairs& regions = RegionPairs()) {
    begin();
    with_.addOwnPairs(surface, &near, regions, found_);
    without_.addOwnPairs(surface, nullptr, regions, expected_);
    compare();
  }

  void check(const MovingSurface& a, const MovingSurface& b) {
    begin();
    with_.addPairs(a, b, &near, 0, found_);
    without_.addPairs(a, b, nullptr, 0, expected_);
    compare();
  }

  NearPairs near;
  int cycles = 0, listed = 0;
  long rows = 0;

 private:
  void begin() {
    found_.begin();
    expected_.begin();
  }
  void compare() {
    found_.finish();
    expected_.finish();
    expectEqual(found_, expected_);
    ++cycles;
    listed += near.hasList() ? 1 : 0;
    rows += found_.size();
  }

  SurfacePairs with_, without_;
  ContactList found_, expected_;
};

/// A fork with prongs of many triangles.
TriangleMesh makeFineFork() {
  return makeCells(Vec3(0.03, 0.012, 0.04), 9, 3, 10, [](int i, int, int k) { return k < 2 || i < 3 || i >= 6; });
}

/// Its tips moved by `shift` [m] towards each other.
std::vector<Vec3> calcClosed(const std::vector<Vec3>& rest, double shift) {
  std::vector<Vec3> nodes = rest;
  for (Vec3& x : nodes) x.x() += (x.x() < 0.015 ? shift : -shift) * std::max(0.0, x.z() - 0.008) / 0.032;
  return nodes;
}

/// Prongs that swing to and fro, into each other, while the whole fork wanders and turns, its nodes tremble, and once
/// in a while it jumps.
class WanderingFork {
 public:
  explicit WanderingFork(unsigned seed, double speed) : random_(seed), speed_(speed), drift_(random_.vector(1)) {}

  std::vector<Vec3> calcNext() {
    time_ += speed_ * random_.uniform(0, 2);
    if (random_.index(40) == 0) time_ += 30;
    if (random_.index(40) == 0) pose_ = random_.pose(0.1);
    pose_ = pose_ * Eigen::AngleAxisd(0.1 * speed_ * random_.uniform(-1, 1), random_.direction());
    pose_.translation() += 0.01 * speed_ * drift_;
    std::vector<Vec3> nodes = calcMoved(calcClosed(mesh.vertices, 4.5e-3 + 1.5e-3 * std::sin(time_)), pose_);
    for (Vec3& x : nodes) x += random_.vector(1e-3 * speed_);
    return nodes;
  }

  const TriangleMesh mesh = makeFineFork();

 private:
  Random random_;
  double speed_;
  Vec3 drift_;
  double time_ = 0;
  Pose pose_ = Pose::Identity();
};

TEST(NearPairs, OfASurfaceWithItselfChangeNoRow) {
  int listed = 0;
  for (const double slope : {0.0, 0.3}) {
    for (const double speed : {0.003, 0.03, 0.3}) {
      WanderingFork fork(static_cast<unsigned>(1000 * speed), speed);
      MovingSurface surface(CollisionSurface(fork.mesh.triangles), fork.mesh.vertices);
      ProximitySettings settings = makeSettings();
      settings.slope = slope;
      Twins twins(settings, surface, surface);
      for (int i = 0; i < 300; ++i) {
        surface.update(fork.calcNext());
        twins.checkOwn(surface);
        if (HasFatalFailure()) return;
      }
      EXPECT_GT(twins.rows, twins.cycles);
      listed += twins.listed;
    }
  }
  EXPECT_GT(listed, 400) << "of 1800";
}

TEST(NearPairs, OfASurfaceWithAMovingObstacleChangeNoRow) {
  for (const double speed : {0.003, 0.03}) {
    Random random(7);
    WanderingFork fork(11, speed);
    MovingSurface surface(CollisionSurface(fork.mesh.triangles), fork.mesh.vertices);
    const TriangleMesh ball = makeBall(0.004, 2);
    MovingSurface obstacle(CollisionSurface(ball.triangles), ball.vertices);
    Twins twins(makeSettings(), surface, obstacle);
    Pose pose = Pose::Identity();
    pose.translation() = Vec3(0.015, 0.006, 0.03);
    for (int i = 0; i < 600; ++i) {
      if (random.index(60) == 0) pose.translation() = Vec3(0.015, 0.006, 0.03) + random.vector(0.004);
      pose = pose * Eigen::AngleAxisd(0.3 * speed, random.direction());
      pose.translation() += 0.01 * speed * random.vector(1);
      obstacle.updateRigid(pose);
      surface.update(i % 100 < 50 ? calcClosed(fork.mesh.vertices, 3e-3 + 3e-3 * std::sin(speed * i))
                                  : fork.calcNext());
      twins.check(surface, obstacle);
      if (HasFatalFailure()) return;
    }
    EXPECT_GT(twins.rows, 600);
    EXPECT_GT(twins.listed, twins.cycles / 3) << speed;
  }
}

TEST(NearPairs, KeepToTheRegionsOfEachCall) {
  WanderingFork fork(5, 0.01);
  MovingSurface surface(CollisionSurface(fork.mesh.triangles), fork.mesh.vertices);
  const int count = static_cast<int>(fork.mesh.triangles.size());
  std::vector<int> first, second;
  for (int t = 0; t < count; ++t) (surface.corner(t, 0).x() < 0.015 ? first : second).push_back(t);
  RegionPairs across, within;
  across.add(first, second, count);
  within.add(first, first, count);
  Twins twins(makeSettings(), surface, surface);
  for (int i = 0; i < 200; ++i) {
    surface.update(fork.calcNext());
    twins.checkOwn(surface, i % 3 == 0 ? across : within);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(twins.listed, 50);
}

TEST(NearPairs, GiveWayToTheSearchWithoutRoomOrAtSpeed) {
  WanderingFork fork(5, 0.001);
  MovingSurface surface(CollisionSurface(fork.mesh.triangles), fork.mesh.vertices);
  ProximitySettings wide;
  wide.alarm_distance = 0.02;
  Twins crowded(wide, surface, surface);
  Twins fast(makeSettings(), surface, surface);
  Random random(3);
  for (int i = 0; i < 20; ++i) {
    surface.update(fork.calcNext());
    crowded.checkOwn(surface);
    surface.update(calcMoved(calcClosed(fork.mesh.vertices, random.uniform(0, 6e-3)), random.pose(1)));
    fast.checkOwn(surface);
    if (HasFatalFailure()) return;
  }
  EXPECT_EQ(crowded.listed, 0);
  EXPECT_LE(fast.listed, 1);
}

TEST(NearPairs, ChangeNoRowWhereTheListOfContactsIsFull) {
  WanderingFork fork(9, 0.01);
  MovingSurface surface(CollisionSurface(fork.mesh.triangles), fork.mesh.vertices);
  Twins twins(makeSettings(), surface, surface, 12);
  for (int i = 0; i < 300; ++i) {
    surface.update(fork.calcNext());
    twins.checkOwn(surface);
    if (HasFatalFailure()) return;
  }
  EXPECT_GT(twins.listed, 75);
}

TEST(NearPairs, BecomePairsOfFeaturesWithoutNeighbours) {
  const TriangleMesh fork = makeFineFork();
  MovingSurface surface(CollisionSurface(fork.triangles), fork.vertices);
  surface.update(calcClosed(fork.vertices, 3e-3));
  NearPairs near(makeSettings(), surface, surface);
  ASSERT_TRUE(near.update(surface, surface));
  EXPECT_FALSE(near.trianglePairs().empty());
  for (int i = 0; i < 20; ++i) ASSERT_TRUE(near.update(surface, surface));
  EXPECT_TRUE(near.trianglePairs().empty());
  EXPECT_FALSE(near.pairs().empty());
  for (const FeaturePair& pair : near.pairs()) {
    if (pair.kind != PairKind::kVertexVertex) continue;
    EXPECT_NE(pair.a, pair.b);
    EXPECT_FALSE(surface.topology().areNeighbours(pair.a, pair.b));
  }
}

TEST(NearPairs, AllocateNothing) {
  WanderingFork fork(5, 0.01);
  MovingSurface surface(CollisionSurface(fork.mesh.triangles), fork.mesh.vertices);
  NearPairs near(makeSettings(), surface, surface);
  long allocations = 0;
  int listed = 0;
  for (int i = 0; i < 200; ++i) {
    surface.update(fork.calcNext());
    const long before = allocationCount();
    listed += near.update(surface, surface) ? 1 : 0;
    allocations += allocationCount() - before;
  }
  EXPECT_GT(listed, 50);
  if (countsAllocations()) {
    EXPECT_EQ(allocations, 0);
  }
}

}  // namespace
}  // namespace sinew
