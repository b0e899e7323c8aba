#include "sinew/solver/scaled_qpcc.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "random_qpcc.h"

namespace sinew {
namespace {

bool isPowerOfTwo(double value) {
  int exponent = 0;
  return std::frexp(value, &exponent) == 0.5;
}

TEST(ScaledQpcc, bringsEntriesNearOneByPowersOfTwo) {
  std::mt19937 random(1);
  for (int k = 0; k < 100; ++k) {
    const QpccProblem problem = makeQpcc(static_cast<QpccKind>(k % 3), 4, 6, random);
    ScaledQpcc scaled(problem.size);
    scaled.update(problem);
    ASSERT_EQ(scaled.size.contacts, 6);
    for (int i = 0; i < 6; ++i) {
      EXPECT_GE(scaled.table(i, i), 0.25);
      EXPECT_LE(scaled.table(i, i), 4);
      EXPECT_TRUE(isPowerOfTwo(scaled.contact_unit(i)));
    }
    EXPECT_LE(scaled.table.cwiseAbs().maxCoeff(), 8);
    EXPECT_TRUE(isPowerOfTwo(scaled.magnitude));
    EXPECT_TRUE(isPowerOfTwo(scaled.effector_scale));
    for (int j = 0; j < 4; ++j) EXPECT_TRUE(isPowerOfTwo(scaled.unknown_unit(j)));
  }
}

TEST(ScaledQpcc, isTheSameProblem) {
  std::mt19937 random(2);
  const QpccProblem p = makeQpcc(QpccKind::kRandom, 3, 5, random);
  ScaledQpcc scaled(p.size);
  scaled.update(p);
  const VecX x = VecX::Random(3);
  const VecX z = VecX::Random(5);
  VecX columns(9);
  columns << z, x, 1;
  const VecX rows = scaled.table * columns;
  const VecX x_si = scaled.magnitude * scaled.unknown_unit.cwiseProduct(x);
  const VecX z_si = scaled.magnitude * scaled.contact_unit.cwiseProduct(z);
  const VecX g = (p.C_a * x_si + p.C_c * z_si + p.c).cwiseProduct(scaled.contact_unit) / scaled.magnitude;
  const VecX a = (p.A_a * x_si + p.A_c * z_si + p.a).cwiseProduct(scaled.row_scale.head(3)) / scaled.magnitude;
  const VecX e = (p.E_a * x_si + p.E_c * z_si + p.e) * (scaled.effector_scale / scaled.magnitude);
  EXPECT_LE((rows.head(5) - g).norm(), 1e-13);
  EXPECT_LE((rows.segment(5, 3) - a).norm(), 1e-13);
  EXPECT_LE((rows.tail(3) - e).norm(), 1e-13);
  const double energy = 0.5 * x.dot(scaled.Q * x) + scaled.q.dot(x);
  EXPECT_NEAR(energy * scaled.objectiveUnit(), 0.5 * x_si.dot(p.Q * x_si) + p.q.dot(x_si), 1e-12);
}

TEST(ScaledQpcc, mergesDuplicateContacts) {
  std::mt19937 random(3);
  QpccProblem problem = makeQpcc(QpccKind::kBar, 3, 6, random);
  duplicateContact(1, 4, 0, problem);
  duplicateContact(2, 5, -1e-3, problem);
  ScaledQpcc scaled(problem.size);
  scaled.update(problem);
  ASSERT_EQ(scaled.size.contacts, 4);
  const bool one = std::count(scaled.contact.begin(), scaled.contact.begin() + 4, 1) +
                       std::count(scaled.contact.begin(), scaled.contact.begin() + 4, 4) ==
                   1;
  EXPECT_TRUE(one);
  EXPECT_EQ(std::count(scaled.contact.begin(), scaled.contact.begin() + 4, 2), 0);  // the nearer one stays
  EXPECT_EQ(std::count(scaled.contact.begin(), scaled.contact.begin() + 4, 5), 1);
}

TEST(ScaledQpcc, keepsOpposingContacts) {
  std::mt19937 random(4);
  QpccProblem problem = makeQpcc(QpccKind::kBar, 2, 2, random);
  duplicateContact(0, 1, 0, problem);
  problem.C_a.row(1) *= -1;
  problem.C_c.row(1) *= -1;
  problem.C_c.col(1) *= -1;
  problem.A_c.col(1) *= -1;
  problem.E_c.col(1) *= -1;
  ScaledQpcc scaled(problem.size);
  scaled.update(problem);
  EXPECT_EQ(scaled.size.contacts, 2);
}

}  // namespace
}  // namespace sinew
