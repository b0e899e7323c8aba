#include "sinew/robot/urdf_frames.h"

#include <gtest/gtest.h>

#include <cmath>

#include "common/complaint.h"
#include "robot/temporary_folder.h"

namespace sinew {
namespace {

// world - a tilted arm - a hand at its end, and a stand beside it; angles in rad.
constexpr const char* kUrdf = R"(<robot name="test">
  <link name="world"/><link name="arm"/><link name="hand"/><link name="stand"/>
  <joint name="1" type="fixed">
    <parent link="world"/><child link="arm"/><origin xyz="1 2 3" rpy="0.3 -0.4 0.5"/>
  </joint>
  <joint name="2" type="revolute">
    <parent link="arm"/><child link="hand"/><origin xyz="0 0 0.5" rpy="0 1.5707963267948966 0"/>
    <axis xyz="0 0 1"/><limit lower="-1" upper="1" effort="1" velocity="1"/>
  </joint>
  <joint name="3" type="fixed"><parent link="world"/><child link="stand"/><origin xyz="-1 0 0"/></joint>
</robot>)";

Pose makePose(const Vec3& position, const Vec3& rpy) {
  return Eigen::Translation3d(position) * Eigen::AngleAxisd(rpy.z(), Vec3::UnitZ()) *
         Eigen::AngleAxisd(rpy.y(), Vec3::UnitY()) * Eigen::AngleAxisd(rpy.x(), Vec3::UnitX());
}

class UrdfFrames : public testing::Test {
 protected:
  TemporaryFolder folder;
  std::string file = folder.write("test.urdf", kUrdf);
  Pose arm = makePose(Vec3(1, 2, 3), Vec3(0.3, -0.4, 0.5));
  Pose hand = arm * makePose(Vec3(0, 0, 0.5), Vec3(0, M_PI / 2, 0));
  Pose stand = makePose(Vec3(-1, 0, 0), Vec3::Zero());

  void expectPose(const std::string& reference, const std::string& frame, const Pose& expected) const {
    const Pose pose = readUrdfPose(file, reference, frame);
    EXPECT_LT((pose.matrix() - expected.matrix()).norm(), 1e-12) << frame << " in " << reference;
  }
};

TEST_F(UrdfFrames, ChainsJointsAtZero) {
  expectPose("world", "world", Pose::Identity());
  expectPose("world", "arm", arm);
  expectPose("world", "hand", hand);
}

TEST_F(UrdfFrames, TurnsChainsAroundAndCrossesBranches) {
  expectPose("arm", "world", arm.inverse());
  expectPose("hand", "stand", hand.inverse() * stand);
  expectPose("stand", "arm", stand.inverse() * arm);
}

TEST_F(UrdfFrames, NamesAMissingLinkAndThoseThatThereAre) {
  const std::string expected = file + ": link: found 'finger', expected one of its links: arm hand stand world";
  EXPECT_EQ(complaintOf([&] { readUrdfPose(file, "world", "finger"); }), expected);
  EXPECT_EQ(complaintOf([&] { readUrdfPose(file, "finger", "world"); }), expected);
}

TEST_F(UrdfFrames, NamesAFileThatIsNoUrdf) {
  for (const std::string& bad : {folder.path() + "/missing.urdf", folder.write("bad.urdf", "<robot name='x'"),
                                 folder.write("other.urdf", "<html/>")}) {
    EXPECT_EQ(complaintOf([&] { readUrdfPose(bad, "world", "arm"); }),
              bad + ": found no readable URDF, expected a URDF file");
  }
}

}  // namespace
}  // namespace sinew
