#include <gtest/gtest.h>

#include "common/complaint.h"
#include "robot/temporary_folder.h"
#include "sinew/robot/obstacle_description.h"

namespace sinew {
namespace {

using Kind = ObstacleGeometry::Kind;

constexpr const char* kUrdf = R"(<robot name="test">
  <link name="world"/>
  <link name="many">
    <collision><origin xyz="1 2 3" rpy="0 0 1.5707963267948966"/><geometry><box size="0.1 0.2 0.3"/></geometry></collision>
    <collision><geometry><sphere radius="0.4"/></geometry></collision>
    <collision><geometry><cylinder radius="0.5" length="0.6"/></geometry></collision>
    <collision><geometry><mesh filename="rock.stl" scale="0.001 0.001 0.002"/></geometry></collision>
    <collision><geometry><mesh filename="file:///rock.stl"/></geometry></collision>
  </link>
  <link name="packaged"><collision><geometry><mesh filename="package://x/rock.stl"/></geometry></collision></link>
  <joint name="1" type="fixed"><parent link="world"/><child link="many"/></joint>
  <joint name="2" type="fixed"><parent link="world"/><child link="packaged"/></joint>
</robot>)";

class UrdfCollision : public testing::Test {
 protected:
  TemporaryFolder folder;
  std::string file = folder.write("test.urdf", kUrdf);
};

TEST_F(UrdfCollision, ReadsEveryShape) {
  const std::vector<ObstacleGeometry> shapes = readUrdfCollision(file, "many");
  ASSERT_EQ(shapes.size(), 5U);
  EXPECT_EQ(shapes[0].kind, Kind::kBox);
  EXPECT_EQ(shapes[0].size, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(shapes[0].origin.translation(), Vec3(1, 2, 3));
  EXPECT_LT((shapes[0].origin.linear() * Vec3::UnitX() - Vec3::UnitY()).norm(), 1e-12);
  EXPECT_EQ(shapes[1].kind, Kind::kSphere);
  EXPECT_EQ(shapes[1].radius, 0.4);
  EXPECT_EQ(shapes[2].kind, Kind::kCylinder);
  EXPECT_EQ(shapes[2].radius, 0.5);
  EXPECT_EQ(shapes[2].length, 0.6);
  EXPECT_EQ(shapes[3].kind, Kind::kMesh);
  EXPECT_EQ(shapes[3].mesh_file, folder.path() + "/rock.stl");
  EXPECT_EQ(shapes[3].scale, Vec3(0.001, 0.001, 0.002));
  EXPECT_EQ(shapes[4].mesh_file, "/rock.stl");
}

TEST_F(UrdfCollision, ComplainsByName) {
  EXPECT_EQ(complaintOf([&] { readUrdfCollision(file, "world"); }),
            file + ": link 'world': collision: found none, expected one collision element or more with a geometry");
  EXPECT_NE(complaintOf([&] { readUrdfCollision(file, "rock"); }).find("found 'rock'"), std::string::npos);
  EXPECT_NE(complaintOf([&] { readUrdfCollision(file, "packaged"); }).find("found 'package://x/rock.stl'"),
            std::string::npos);
}

}  // namespace
}  // namespace sinew
