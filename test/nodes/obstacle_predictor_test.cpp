#include "obstacle_predictor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace sinew {
namespace {

using Verdict = ObstaclePredictor::Verdict;

const Vec3 kVelocity(0.04, -0.03, 0);  // m/s
const Vec3 kTurnRate(0, 0, 0.6);       // rad/s

/// Even motion: along a line, and turning about z.
Pose poseAt(double time) {
  Pose pose = Pose::Identity();
  pose.translation() = Vec3(0.1, 0.2, 0.3) + time * kVelocity;
  pose.linear() =
      (Eigen::AngleAxisd(kTurnRate.z() * time, Vec3::UnitZ()) * Eigen::AngleAxisd(0.7, Vec3::UnitX())).matrix();
  return pose;
}

double calcAngle(const Pose& a, const Pose& b) {
  return std::abs(Eigen::AngleAxisd(Mat3(a.linear().transpose() * b.linear())).angle());
}

Pose makeShifted(const Vec3& shift) {
  Pose pose = Pose::Identity();
  pose.translation() = shift;
  return pose;
}

TEST(ObstaclePredictor, FollowsAnEvenMotionWithoutLag) {
  for (const double rate : {30.0, 45.0, 60.0}) {
    ObstaclePredictor predictor{ObstaclePredictor::Settings()};
    double time = 0;
    for (; time < 2; time += 1 / rate) predictor.add(time, poseAt(time));
    const Pose predicted = predictor.motion().calcPose(time + 0.05, 1);
    EXPECT_LT((predicted.translation() - poseAt(time + 0.05).translation()).norm(), 1e-9);
    EXPECT_LT(calcAngle(predicted, poseAt(time + 0.05)), 1e-8);
    EXPECT_LT((predictor.motion().velocity - kVelocity).norm(), 1e-9);
    EXPECT_LT((predictor.motion().turn_rate - kTurnRate).norm(), 1e-8);
  }
}

TEST(ObstaclePredictor, TurnsThroughAFullCircle) {
  ObstaclePredictor predictor{ObstaclePredictor::Settings()};
  for (double time = 0; time < 2.5 * M_PI / kTurnRate.z(); time += 1 / 60.0) {
    ASSERT_NE(Verdict::kOutlier, predictor.add(time, poseAt(time)));
    if (time < 1) continue;
    ASSERT_LT(calcAngle(predictor.motion().calcPose(time, 0), poseAt(time)), 1e-6);
  }
}

// The variances of a filter of fading memory at even sampling, by summing its weights: with q = theta,
//   var(position) = (1 - q)(1 + 4 q + 5 q^2) / (1 + q)^3,   var(velocity) = 2 (1 - q)^3 / (1 + q)^3 / dt^2.
TEST(ObstaclePredictor, NoiseIsWhatTheFilterTimeLeavesOfIt) {
  constexpr double kNoise = 0.0003, kPeriod = 1 / 60.0;
  ObstaclePredictor::Settings settings;
  const double q = std::exp(-kPeriod / settings.filter_time);
  const double position = std::sqrt((1 - q) * (1 + 4 * q + 5 * q * q) / std::pow(1 + q, 3));
  const double velocity = std::sqrt(2 * std::pow((1 - q) / (1 + q), 3)) / kPeriod;

  ObstaclePredictor predictor(settings);
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0, kNoise);
  double position_squares = 0, velocity_squares = 0;
  constexpr int kSamples = 60000;
  for (int i = 0; i < kSamples; ++i) {
    ASSERT_NE(Verdict::kOutlier, predictor.add(i * kPeriod, makeShifted(Vec3(noise(random), 0, 0))));
    position_squares += std::pow(predictor.motion().position.x(), 2);
    velocity_squares += std::pow(predictor.motion().velocity.x(), 2);
  }
  EXPECT_NEAR(1, std::sqrt(position_squares / kSamples) / (kNoise * position), 0.03);
  EXPECT_NEAR(1, std::sqrt(velocity_squares / kSamples) / (kNoise * velocity), 0.03);
}

TEST(ObstaclePredictor, KeepsTheStateOfTheWorldWithinTheHorizon) {
  ObstaclePredictor predictor{ObstaclePredictor::Settings()};
  for (double time = 0; time < 1; time += 1 / 60.0) predictor.add(time, poseAt(time));
  const ObstacleMotion& motion = predictor.motion();
  EXPECT_EQ(motion.calcPose(motion.time + 0.1, 0.1).matrix(), motion.calcPose(motion.time + 5, 0.1).matrix());
  EXPECT_EQ(motion.calcPose(motion.time, 0.1).matrix(), motion.calcPose(motion.time - 5, 0.1).matrix());
}

TEST(ObstaclePredictor, CapsTheSpeed) {
  ObstaclePredictor::Settings settings;
  settings.max_speed = 0.02;
  settings.max_turn_rate = 0.1;
  ObstaclePredictor predictor(settings);
  for (double time = 0; time < 1; time += 1 / 60.0) {
    predictor.add(time, poseAt(time));
    ASSERT_LE(predictor.motion().velocity.norm(), 0.02 + 1e-12);
    ASSERT_LE(predictor.motion().turn_rate.norm(), 0.1 + 1e-12);
  }
  EXPECT_NEAR(0.02, predictor.motion().velocity.norm(), 1e-9);
}

TEST(ObstaclePredictor, AnOutlierChangesNothing) {
  ObstaclePredictor predictor{ObstaclePredictor::Settings()};
  double time = 0;
  for (; time < 1; time += 1 / 60.0) predictor.add(time, poseAt(time));
  const Pose before = predictor.motion().calcPose(time, 1);
  EXPECT_EQ(Verdict::kOutlier, predictor.add(time, makeShifted(Vec3(0.04, 0, 0)) * poseAt(time)));
  EXPECT_EQ(1u, predictor.outliers());
  EXPECT_NEAR(0.04, predictor.lastJump(), 1e-6);
  EXPECT_EQ(before.matrix(), predictor.motion().calcPose(time, 1).matrix());

  Pose turned = poseAt(time);
  turned.rotate(Eigen::AngleAxisd(0.6, Vec3::UnitY()));
  EXPECT_EQ(Verdict::kOutlier, predictor.add(time, turned));
  EXPECT_EQ(2u, predictor.outliers());
  EXPECT_EQ(Verdict::kTaken, predictor.add(time, poseAt(time)));
}

TEST(ObstaclePredictor, BelievesAJumpThatLasts) {
  ObstaclePredictor predictor{ObstaclePredictor::Settings()};
  int sample = 0;
  const auto add = [&](const Vec3& position) { return predictor.add(++sample / 60.0, makeShifted(position)); };
  for (int i = 0; i < 60; ++i) add(Vec3::Zero());
  const Vec3 there(0.2, 0, 0);
  for (int i = 0; i < 4; ++i) EXPECT_EQ(Verdict::kOutlier, add(there));
  EXPECT_EQ(Verdict::kBegun, add(there));
  EXPECT_EQ(there, predictor.motion().position);
  EXPECT_EQ(Vec3(Vec3::Zero()), predictor.motion().velocity) << "a jump is no speed";

  // Outliers that do not agree with each other, or that are not in a row, stay outliers.
  for (int i = 0; i < 12; ++i) EXPECT_EQ(Verdict::kOutlier, add(there + Vec3(0.1 * (i % 2 + 1), 0, 0)));
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ(i % 4 == 3 ? Verdict::kTaken : Verdict::kOutlier, add(i % 4 == 3 ? there : Vec3(Vec3::Zero())));
  }
}

TEST(ObstaclePredictor, BeginsAnewAfterSilence) {
  ObstaclePredictor predictor{ObstaclePredictor::Settings()};
  EXPECT_EQ(Verdict::kBegun, predictor.add(0, makeShifted(Vec3::Zero())));
  EXPECT_EQ(Verdict::kTaken, predictor.add(0.1, makeShifted(Vec3(0.01, 0, 0))));
  EXPECT_EQ(Verdict::kBegun, predictor.add(0.7, makeShifted(Vec3(1, 0, 0))));
  predictor.forget();
  EXPECT_EQ(Verdict::kBegun, predictor.add(0.71, makeShifted(Vec3(2, 0, 0))));
  EXPECT_EQ(0u, predictor.outliers());
}

TEST(ObstaclePredictor, LeavesOutWhatComesLate) {
  ObstaclePredictor predictor{ObstaclePredictor::Settings()};
  for (double time = 0; time < 1; time += 1 / 60.0) predictor.add(time, poseAt(time));
  const ObstacleMotion before = predictor.motion();
  EXPECT_EQ(Verdict::kLate, predictor.add(before.time, poseAt(before.time)));
  EXPECT_EQ(Verdict::kLate, predictor.add(before.time - 0.02, poseAt(before.time)));
  EXPECT_EQ(before.position, predictor.motion().position);
}

// What the controller's tests assume of a tracker at 60 Hz that is 30 ms late: once the speed is known, the obstacle is
// predicted to a fraction of a millisecond's noise; while it starts, no worse than its way within latency and filter.
TEST(ObstaclePredictor, PredictsAcrossTheTrackersLatency) {
  constexpr double kLatency = 0.03, kNoise = 0.0003, kSpeed = 0.05;
  const auto way = [](double time) { return kSpeed * std::max(0.0, time - 1); };
  ObstaclePredictor predictor{ObstaclePredictor::Settings()};
  std::mt19937 random(5);
  std::normal_distribution<double> noise(0, kNoise);
  double worst_starting = 0, squares = 0;
  int sample = 0, steady = 0;
  for (int cycle = 0; cycle < 300; ++cycle) {
    const double now = 0.01 * cycle;
    for (; sample / 60.0 + kLatency <= now; ++sample) {
      predictor.add(sample / 60.0, makeShifted(Vec3(way(sample / 60.0) + noise(random), 0, 0)));
    }
    if (sample == 0) continue;
    const double error = predictor.motion().calcPose(now + 0.01, 0.1).translation().x() - way(now + 0.01);
    if (now < 1.5) {
      worst_starting = std::max(worst_starting, std::abs(error));
    } else {
      squares += error * error;
      ++steady;
    }
  }
  EXPECT_LT(std::sqrt(squares / steady), 0.0004);
  EXPECT_LT(worst_starting, kSpeed * (kLatency + 0.01 + 0.05));
  EXPECT_GT(worst_starting, kSpeed * kLatency / 2) << "nobody can foresee the start";
}

}  // namespace
}  // namespace sinew
