#include "sinew/solver/qpcc_problem.h"

#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <string>

#include "allocation_count.h"

namespace sinew {
namespace {

TEST(QpccProblem, startsWithoutLimits) {
  const QpccProblem problem({2, 3, 1, 4});
  EXPECT_EQ(problem.size.contacts, 4);
  EXPECT_EQ(problem.x_lower.maxCoeff(), -std::numeric_limits<double>::infinity());
  EXPECT_EQ(problem.soft_upper.minCoeff(), std::numeric_limits<double>::infinity());
  EXPECT_EQ(problem.row_lower.maxCoeff(), -std::numeric_limits<double>::infinity());
  EXPECT_TRUE(problem.C_c.isZero(0));
}

TEST(QpccProblem, resizesWithoutAllocation) {
  QpccProblem problem({2, 3, 1, 4});
  problem.C_c(1, 1) = 7;
  const long before = allocationCount();
  problem.resize({1, 0, 1, 2});
  problem.resize({2, 3, 0, 4});
  EXPECT_EQ(allocationCount(), before);
  EXPECT_EQ(problem.size.rows, 3);
  EXPECT_EQ(problem.C_c(1, 1), 7);
}

TEST(QpccStatus, hasNames) {
  std::set<std::string> names;
  for (const QpccStatus status : {QpccStatus::kSolved, QpccStatus::kGivenWay, QpccStatus::kInfeasible,
                                  QpccStatus::kNotFinite, QpccStatus::kFailed})
    names.insert(nameOf(status));
  EXPECT_EQ(names.size(), 5u);
}

}  // namespace
}  // namespace sinew
