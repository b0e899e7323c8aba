#include "sinew/fem/rotation.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <random>

namespace sinew {
namespace {

// The rotation that maximises tr(R^T F), from the singular values with the sign on the smallest.
Mat3 oracle(const Mat3& F) {
  const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Mat3 sign = Mat3::Identity();
  sign(2, 2) = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
  return svd.matrixU() * sign * svd.matrixV().transpose();
}

Mat3 randomMatrix(std::mt19937& random) {
  std::normal_distribution<double> normal;
  Mat3 F;
  for (int i = 0; i < 9; ++i) F(i / 3, i % 3) = normal(random);
  return F;
}

void expectProper(const Mat3& R) {
  EXPECT_LT((R.transpose() * R - Mat3::Identity()).norm(), 1e-13);
  EXPECT_GT(R.determinant(), 0);
}

TEST(Rotation, MaximisesTheTraceForAnyMatrix) {
  std::mt19937 random(3);
  for (int trial = 0; trial < 20000; ++trial) {
    const Mat3 F = randomMatrix(random);
    Mat3 R = Mat3::Identity();
    updateRotation(F, R);
    expectProper(R);
    EXPECT_GT((R.transpose() * F).trace(), (oracle(F).transpose() * F).trace() - 1e-9 * F.norm());
  }
}

TEST(Rotation, FollowsFromAWarmStart) {
  std::mt19937 random(4);
  Mat3 R = Mat3::Identity();
  for (int step = 0; step < 10000; ++step) {
    const Mat3 turn = Eigen::AngleAxisd(0.001 * step, Vec3(1, 1, 0.5).normalized()).toRotationMatrix();
    const Mat3 F = turn * (Mat3::Identity() + 0.1 * randomMatrix(random) / 3);
    updateRotation(F, R);
    expectProper(R);
    EXPECT_LT((R - oracle(F)).norm(), 1e-12);
  }
}

TEST(Rotation, IsProperForFlatInvertedAndCollapsedElements) {
  for (const Vec3& s :
       {Vec3(1, 1, 0), Vec3(1, 0, 0), Vec3(0, 0, 0), Vec3(1, 1, -1), Vec3(-1, -1, -1), Vec3(2, 1, -0.1)}) {
    Mat3 R = Mat3::Identity();
    updateRotation(s.asDiagonal() * Mat3::Identity(), R);
    expectProper(R);
  }
}

}  // namespace
}  // namespace sinew
