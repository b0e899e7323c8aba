#include "sinew/inverse/obstacle.h"

#include <gtest/gtest.h>

#include "common/complaint.h"
#include "robot/temporary_folder.h"

namespace sinew {
namespace {

// The corner tetrahedron of a cube with edges of 10 mm, in mm.
constexpr const char* kStl = R"(solid corner
facet normal 0 0 -1 outer loop vertex 0 0 0 vertex 0 10 0 vertex 10 0 0 endloop endfacet
facet normal 0 -1 0 outer loop vertex 0 0 0 vertex 10 0 0 vertex 0 0 10 endloop endfacet
facet normal -1 0 0 outer loop vertex 0 0 0 vertex 0 0 10 vertex 0 10 0 endloop endfacet
facet normal 1 1 1 outer loop vertex 10 0 0 vertex 0 10 0 vertex 0 0 10 endloop endfacet
endsolid corner
)";

ObstacleDescription describe(const ObstacleGeometry& geometry) {
  ObstacleDescription description;
  description.name = "thing";
  description.geometries = {geometry};
  return description;
}

TEST(Obstacle, HasTheShapesOfItsDescription) {
  ObstacleGeometry box;
  box.kind = ObstacleGeometry::Kind::kBox;
  box.size = Vec3(0.2, 0.4, 0.6);
  box.origin.translation() = Vec3(1, 2, 3);
  const Obstacle obstacle = makeObstacle(describe(box));
  EXPECT_EQ(obstacle.name, "thing");
  ASSERT_EQ(obstacle.parts.size(), 1U);
  EXPECT_EQ(obstacle.parts[0].origin.translation(), Vec3(1, 2, 3));
  EXPECT_NEAR(obstacle.parts[0].shape.calcDistance(Vec3(0.3, 0, 0)).distance, 0.2, 1e-12);
}

TEST(Obstacle, ReadsAMeshInItsScale) {
  TemporaryFolder folder;
  ObstacleGeometry mesh;
  mesh.kind = ObstacleGeometry::Kind::kMesh;
  mesh.mesh_file = folder.write("corner.stl", kStl);
  mesh.scale = Vec3::Constant(0.001);
  const Obstacle obstacle = makeObstacle(describe(mesh));
  const ObstacleShape& shape = obstacle.parts[0].shape;
  EXPECT_NEAR(shape.calcDistance(Vec3(-0.002, 0.003, 0.003)).distance, 0.002, 1e-12);
  EXPECT_NEAR(shape.calcDistance(Vec3(0.001, 0.002, 0.002)).distance, -0.001, 1e-12) << "inside";
  mesh.mesh_file = folder.path() + "/none.stl";
  EXPECT_NE(complaintOf([&] { makeObstacle(describe(mesh)); }).find("none.stl"), std::string::npos);
}

TEST(Obstacle, NamesTheFileOfAMeshThatIsOpen) {
  TemporaryFolder folder;
  ObstacleGeometry mesh;
  mesh.kind = ObstacleGeometry::Kind::kMesh;
  std::string open = kStl;
  open.erase(open.find("facet normal 1 1 1"), open.find("endsolid") - open.find("facet normal 1 1 1"));
  mesh.mesh_file = folder.write("open.stl", open);
  const std::string complaint = complaintOf([&] { makeObstacle(describe(mesh)); });
  EXPECT_EQ(complaint.find(mesh.mesh_file + ": "), 0U) << complaint;
  EXPECT_NE(complaint.find("expected a closed surface"), std::string::npos) << complaint;
}

}  // namespace
}  // namespace sinew
