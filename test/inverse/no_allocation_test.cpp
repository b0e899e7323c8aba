// The cycle of the controller takes no memory: not with contacts that come and go, not with limits that give way, not
// while it holds.

#include <cmath>

#include "check_line.h"
#include "inverse/robots.h"
#include "solver/allocation_count.h"

namespace sinew {
namespace {

constexpr double kTurn = 6.283185307179586;  // rad
constexpr int kWarmUp = 20;                  // cycles

/// Sways every effector about its place at rest, and brings obstacles to and fro.
class SwayingRun {
 public:
  explicit SwayingRun(const RobotDescription& description) : robot_(makeRobot(description)) {
    controller_.resynchronise(VecX::Zero(robot_->actuatorCount()));
    input_.targeted.assign(input_.targeted.size(), true);
    for (const Obstacle& obstacle : robot_->obstacles()) input_.obstacles.push_back({obstacle.pose, true});
  }

  /// Allocations in `cycles` cycles; in the first ones nothing counts.
  long count(int cycles, const Vec3& sway, const Vec3& approach) {
    long allocations = 0;
    for (int k = 0; k < kWarmUp + cycles; ++k) {
      place(k * 0.01, sway, approach);
      const long before = allocationCount();
      controller_.prepare(output_);
      controller_.step(input_, output_);
      if (k >= kWarmUp) allocations += allocationCount() - before;
      cycles_in_contact_ += output_.contacts.count > 0;
    }
    return allocations;
  }

  int cyclesInContact() const { return cycles_in_contact_; }

 private:
  void place(double time, const Vec3& sway, const Vec3& approach) {
    for (int e = 0; e < robot_->effectorCount(); ++e) {
      input_.targets.segment<3>(3 * e) = robot_->description().effectors[e].point + std::sin(kTurn * time / 3) * sway;
    }
    for (std::size_t i = 0; i < input_.obstacles.size(); ++i) {
      const Pose& waiting = robot_->obstacles()[i].pose;
      input_.obstacles[i].pose = Eigen::Translation3d(approach * (0.5 - 0.5 * std::cos(kTurn * time / 2.2))) * waiting;
      input_.obstacles[i].present = std::fmod(time, 5) > 0.5;
    }
  }

  std::shared_ptr<const RobotModel> robot_;
  InverseController controller_{robot_};
  CycleInput input_ = controller_.makeInput();
  CycleOutput output_ = controller_.makeOutput();
  int cycles_in_contact_ = 0;
};

void expectNone(const std::string& name, const RobotDescription& description, int cycles, const Vec3& sway,
                const Vec3& approach) {
  if (!countsAllocations()) GTEST_SKIP() << "nothing counts allocations in this build";
  SwayingRun run(description);
  checkFigure("no_allocation." + name, static_cast<double>(run.count(cycles, sway, approach)), "<=", 0, "1");
  EXPECT_GT(run.cyclesInContact(), cycles / 20);
}

TEST(NoAllocation, FingerAndItsPost) {
  expectNone("finger", readShippedRobot("finger"), 10000, Vec3(0, 0.01, -0.01), Vec3(0, -0.02, 0));
}

TEST(NoAllocation, TrunkAndACylinderByVolume) {
  RobotDescription description = readShippedRobot("trunk_cylinder");
  description.contacts.method = DetectionMethod::kVolume;
  expectNone("trunk_volume", description, 300, Vec3(0.01, 0, -0.01), Vec3(-0.034, 0, 0));
}

TEST(NoAllocation, GripperAndItsBall) {
  expectNone("gripper", readShippedRobot("gripper"), 300, Vec3(0.002, 0.002, -0.002), Vec3(0.01, 0, 0));
}

TEST(NoAllocation, TentacleThatCurls) {
  RobotDescription description = readShippedRobot("tentacle");
  expectNone("tentacle", description, 300, Vec3(-0.1, 0, -0.1), Vec3::Zero());
}

TEST(NoAllocation, MovingTrunkOnItsRail) {
  RobotDescription description = readShippedRobot("trunk_rail");
  description.control.model = MotionModel::kDynamic;
  expectNone("trunk_rail", description, 300, Vec3(0.02, 0, 0.1), Vec3(0, 0, -0.04));
}

}  // namespace
}  // namespace sinew
