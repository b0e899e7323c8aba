#include "sinew/contact/feature_pair.h"

#include <gtest/gtest.h>

#include <set>

#include "contact/shapes.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

TEST(FeaturePair, KeysAreDifferentForDifferentPairsAndInTheirOrder) {
  std::set<std::uint64_t> keys;
  std::uint64_t last = 0;
  for (const int obstacle : {kOtherSurface, kSelfContact, 0, 500}) {
    for (const PairKind kind : {PairKind::kVertexSmooth, PairKind::kEdgeEdge, PairKind::kVolume}) {
      for (const int a : {0, 1, 33000000}) {
        for (const int b : {0, 1, 33000000}) {
          const std::uint64_t key = makeContactKey(obstacle, kind, a, b);
          EXPECT_TRUE(keys.insert(key).second);
          EXPECT_GE(key, last);
          last = key;
        }
      }
    }
  }
}

TEST(FeaturePair, PointsAreWhereTheirWeightsSay) {
  const TriangleMesh mesh = makeTetrahedron(1);
  MovingSurface surface(CollisionSurface(mesh.triangles), mesh.vertices);
  std::vector<Vec3> moved = mesh.vertices;
  for (Vec3& x : moved) x += Vec3(0, 0, 2);
  surface.update(moved);
  const SurfacePoint point = SurfacePoint::onFace(surface, 3, Vec3(0.2, 0.3, 0.5));
  EXPECT_LT((point.position - Vec3(0.2, 0.3, 2.5)).norm(), 1e-15);
  EXPECT_LT((point.calcRestPosition(surface) - Vec3(0.2, 0.3, 0.5)).norm(), 1e-15);
  EXPECT_EQ(SurfacePoint::atVertex(surface, 1).position, moved[1]);
}

TEST(FeaturePair, FilterHoldsOnToWhatWasThere) {
  ProximitySettings settings;
  const PairFilter filter(settings);
  ContactList list(4, 4);
  list.begin();
  ContactRow row;
  row.key = 9;
  list.add(row, nullptr, 0);
  list.finish();
  list.begin();
  const double far = settings.alarm_distance * (1 + settings.hysteresis / 2);
  EXPECT_TRUE(filter.accepts(far, 0, 9, list));
  EXPECT_FALSE(filter.accepts(far, 0, 8, list));
  EXPECT_FALSE(filter.accepts(2 * far, 0, 9, list));
  EXPECT_TRUE(filter.accepts(0, -settings.slope * (1 + settings.hysteresis / 2), 9, list));
  EXPECT_FALSE(filter.accepts(0, -settings.slope * (1 + settings.hysteresis / 2), 8, list));
}

TEST(FeaturePair, SettingsNameWhatIsWrong) {
  ProximitySettings settings;
  settings.slope = 2;
  try {
    settings.check();
    FAIL();
  } catch (const ConfigError& error) {
    EXPECT_NE(std::string(error.what()).find("slope"), std::string::npos);
  }
}

}  // namespace
}  // namespace sinew
