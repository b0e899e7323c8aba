#include "target_trajectory.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

const Vec3 kCentre(0.01, -0.02, 0.2);
constexpr double kRadius = 0.04;

TrajectoryTiming makeTiming() {
  TrajectoryTiming timing;
  timing.period = 8;
  timing.turns = 2;
  return timing;
}

Vec3 calcFirst(const TargetTrajectory& trajectory, double time) {
  std::vector<Vec3> positions;
  trajectory.calcPositions(time, positions);
  return positions.front();
}

class CsvFile {
 public:
  explicit CsvFile(const std::string& text)
      : path_(::testing::TempDir() + "sinew_trajectory_" + std::to_string(getpid()) + ".csv") {
    std::ofstream(path_) << text;
  }
  ~CsvFile() { std::remove(path_.c_str()); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

TEST(TargetTrajectory, CircleKeepsItsRadiusAndItsSpeed) {
  const TargetTrajectory circle = TargetTrajectory::makeCircle("tip", kCentre, kRadius, makeTiming());
  EXPECT_EQ(circle.duration(), 16);
  EXPECT_TRUE(calcFirst(circle, 0).isApprox(kCentre + Vec3(kRadius, 0, 0), 1e-12));
  EXPECT_TRUE(calcFirst(circle, 2).isApprox(kCentre + Vec3(0, kRadius, 0), 1e-12));
  std::vector<Vec3> velocities;
  for (double time = 0; time <= 16; time += 0.37) {
    const Vec3 arm = calcFirst(circle, time) - kCentre;
    EXPECT_NEAR(arm.norm(), kRadius, 1e-12);
    circle.calcVelocities(time, velocities);
    EXPECT_NEAR(velocities.front().norm(), 2 * M_PI * kRadius / 8, 1e-6);
  }
  EXPECT_EQ(calcFirst(circle, -1), calcFirst(circle, 0));
  EXPECT_EQ(calcFirst(circle, 17), calcFirst(circle, 16));
}

TEST(TargetTrajectory, SquareRunsAlongItsSidesAtConstantSpeed) {
  const TargetTrajectory square = TargetTrajectory::makeSquare("tip", kCentre, kRadius, makeTiming());
  const double speed = 4 * std::sqrt(2.0) * kRadius / 8;
  for (double time = 0.05; time < 16; time += 0.1) {
    const Vec3 position = calcFirst(square, time) - kCentre;
    EXPECT_NEAR(std::abs(position.x()) + std::abs(position.y()), kRadius, 1e-12);
    const Vec3 step = calcFirst(square, time + 1e-4) - calcFirst(square, time);
    EXPECT_NEAR(step.norm() / 1e-4, speed, 1e-6);
  }
}

TEST(TargetTrajectory, SShapeHoldsMiddleAndTipOnOppositeSides) {
  const Vec3 middle_centre(0, 0, 0.1);
  const TargetTrajectory shape =
      TargetTrajectory::makeSShape("tip", kCentre, kRadius, "middle", middle_centre, 0.01, makeTiming());
  ASSERT_EQ(shape.effectors(), (std::vector<std::string>{"tip", "middle"}));
  std::vector<Vec3> positions;
  for (double time = 0; time <= 16; time += 0.61) {
    shape.calcPositions(time, positions);
    const Vec3 tip = positions[0] - kCentre;
    const Vec3 middle = positions[1] - middle_centre;
    EXPECT_NEAR(tip.dot(middle), -kRadius * 0.01, 1e-12);
  }
}

TEST(TargetTrajectory, CsvIsLinearBetweenItsLines) {
  const CsvFile file("t,target_tip_x,other,target_tip_y,target_tip_z\n1,0,9,0,0.2\n2, 0.1,9,0.2,0.4\r\n\n4,0,9,0,0\n");
  const TargetTrajectory path = TargetTrajectory::readCsv(file.path());
  EXPECT_EQ(path.effectors(), std::vector<std::string>{"tip"});
  EXPECT_EQ(path.duration(), 3);
  EXPECT_TRUE(calcFirst(path, 0.5).isApprox(Vec3(0.05, 0.1, 0.3), 1e-12));
  EXPECT_TRUE(calcFirst(path, 2).isApprox(Vec3(0.05, 0.1, 0.2), 1e-12));
  EXPECT_EQ(calcFirst(path, 9), Vec3(0, 0, 0));
}

TEST(TargetTrajectory, CsvNamesWhatIsWrong) {
  const auto complain = [](const std::string& text) -> std::string {
    const CsvFile file(text);
    try {
      TargetTrajectory::readCsv(file.path());
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "nothing";
  };
  const auto names = [](const std::string& words, const std::string& part) {
    return words.find(part) != std::string::npos ? ::testing::AssertionSuccess()
                                                 : ::testing::AssertionFailure() << words;
  };
  const std::string header = "t,target_tip_x,target_tip_y,target_tip_z\n";
  EXPECT_TRUE(names(complain("t,x\n0,0\n"), "target_NAME_x"));
  EXPECT_TRUE(names(complain("t,target_tip_x,target_tip_y\n0,0,0\n"), "target_tip_z"));
  EXPECT_TRUE(names(complain("target_tip_x,target_tip_y,target_tip_z\n0,0,0\n"), "column t"));
  EXPECT_TRUE(names(complain(header), "no line"));
  EXPECT_TRUE(names(complain(header + "0,0,0\n"), ":2"));
  EXPECT_TRUE(names(complain(header + "0,0,nan,0\n"), "target_tip_y"));
  EXPECT_TRUE(names(complain(header + "0,0,1,0\n0,0,1,0\n"), ":3: t"));
}

TEST(TargetTrajectory, RampStartsAtRestAndEndsInThePathsMotion) {
  const Vec3 start(0, 0, 0.2), end(0.04, 0.01, 0.19), velocity(0, 0.03, 0.01);
  constexpr double kDuration = 3, kStep = 1e-4;
  const auto ramp = [&](double time) { return calcRamp(start, end, velocity, kDuration, time); };
  const auto differ = [&](double time) { return Vec3((ramp(time + kStep) - ramp(time - kStep)) / (2 * kStep)); };
  EXPECT_TRUE(ramp(0).isApprox(start, 1e-12));
  EXPECT_TRUE(ramp(kDuration).isApprox(end, 1e-12));
  EXPECT_LT(differ(kStep).norm(), 1e-6);
  EXPECT_LT((differ(kDuration - kStep) - velocity).norm(), 1e-6);
  EXPECT_LT((differ(2 * kStep) - differ(kStep)).norm() / kStep, 1e-3);
  EXPECT_LT((differ(kDuration - kStep) - differ(kDuration - 2 * kStep)).norm() / kStep, 1e-3);
  EXPECT_EQ(calcRamp(start, end, velocity, 0, 0), end);
}

}  // namespace
}  // namespace sinew
