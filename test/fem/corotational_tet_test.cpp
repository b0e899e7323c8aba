#include "sinew/fem/corotational_tet.h"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <random>

namespace sinew {
namespace {

class CorotationalTet : public testing::Test {
 protected:
  std::mt19937 random_{7};
  Lame lame_ = calcLame(1e5, 0.4);
  std::array<Vec3, 4> rest_{{Vec3(0, 0, 0), Vec3(1, 0.1, 0), Vec3(0.2, 0.9, -0.1), Vec3(0, 0.3, 1.1)}};
  TetShape shape_ = makeTetShape(rest_);

  TetGradients deformed(double size) {
    std::normal_distribution<double> normal;
    const Mat3 R = Eigen::Quaterniond(normal(random_), normal(random_), normal(random_), normal(random_))
                       .normalized()
                       .toRotationMatrix();
    TetGradients x;
    for (int a = 0; a < 4; ++a) {
      x.col(a) = R * (rest_[a] + size * Vec3(normal(random_), normal(random_), normal(random_)));
    }
    return x;
  }

  Eigen::Matrix<double, 12, 12> full(const TetLinearisation& result) const {
    Eigen::Matrix<double, 12, 12> K;
    for (int a = 0, k = 0; a < 4; ++a) {
      for (int b = 0; b <= a; ++b, ++k) {
        K.block<3, 3>(3 * a, 3 * b) = result.stiffness[k];
        K.block<3, 3>(3 * b, 3 * a) = result.stiffness[k].transpose();
      }
    }
    return K;
  }
};

TEST_F(CorotationalTet, ExactTangentIsTheDerivativeOfTheForces) {
  for (double size : {0.01, 0.1, 0.2}) {
    const TetGradients x = deformed(size);
    Mat3 R = Mat3::Identity();
    TetLinearisation result;
    calcTetLinearisation(shape_, lame_, x, Tangent::kExact, R, result);
    const auto K = full(result);
    const double h = 1e-6;
    for (int i = 0; i < 12; ++i) {
      TetGradients plus = x, minus = x, f_plus, f_minus;
      plus(i % 3, i / 3) += h;
      minus(i % 3, i / 3) -= h;
      calcTetForces(shape_, lame_, plus, R, f_plus);
      calcTetForces(shape_, lame_, minus, R, f_minus);
      const Eigen::Map<const Eigen::Matrix<double, 12, 1>> p(f_plus.data()), m(f_minus.data());
      EXPECT_LT((K.col(i) + (p - m) / (2 * h)).norm(), 1e-7 * K.norm()) << "size " << size << " column " << i;
    }
  }
}

TEST_F(CorotationalTet, SemidefiniteTangentHasNoNegativeEigenvalue) {
  for (int trial = 0; trial < 50; ++trial) {
    const TetGradients x = deformed(0.15) * (trial % 2 == 0 ? 0.8 : 1.2);
    Mat3 R = Mat3::Identity();
    TetLinearisation exact, result;
    calcTetLinearisation(shape_, lame_, x, Tangent::kSemidefinite, R, result);
    calcTetLinearisation(shape_, lame_, x, Tangent::kExact, R, exact);
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix<double, 12, 12>> semidefinite(full(result)),
        difference(full(result) - full(exact));
    EXPECT_GT(semidefinite.eigenvalues().minCoeff(), -1e-9 * full(result).norm());
    EXPECT_GT(difference.eigenvalues().minCoeff(), -1e-6 * full(result).norm());
  }
}

TEST_F(CorotationalTet, ForcesBalance) {
  const TetGradients x = deformed(0.2);
  Mat3 R = Mat3::Identity();
  TetGradients forces;
  calcTetForces(shape_, lame_, x, R, forces);
  Vec3 moment = Vec3::Zero();
  for (int a = 0; a < 4; ++a) moment += Vec3(x.col(a)).cross(Vec3(forces.col(a)));
  EXPECT_LT(forces.rowwise().sum().norm(), 1e-12 * forces.norm());
  EXPECT_LT(moment.norm(), 1e-10 * forces.norm());
}

}  // namespace
}  // namespace sinew
