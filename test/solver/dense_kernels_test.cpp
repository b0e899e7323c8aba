#include "sinew/solver/dense_kernels.h"

#include <gtest/gtest.h>

#include <vector>

#include "sinew/common/types.h"

namespace sinew {
namespace {

constexpr int kStride = 70;
constexpr double kGuard = 7;  // around what may be written

class DenseKernelsTest : public testing::TestWithParam<InstructionSet> {
 protected:
  const DenseKernels& kernels = denseKernelsOf(GetParam());
  MatX matrix = MatX::Random(kStride, 40);

  /// Every number of rows and columns up to some vectors, with a rest.
  template <typename Check>
  static void forEachSize(const Check& check) {
    for (const int rows : {0, 1, 2, 3, 7, 8, 9, 15, 31, 32, 33, 40, 64, 69}) {
      for (const int columns : {0, 1, 3, 4, 5, 39}) check(rows, columns);
    }
  }
};

TEST_P(DenseKernelsTest, AddColumns) {
  forEachSize([&](int rows, int columns) {
    const VecX x = VecX::Random(40);
    VecX sum = VecX::Constant(kStride, kGuard);
    kernels.addColumns(matrix.data(), kStride, rows, x.data(), columns, sum.data());
    const VecX expected = matrix.topLeftCorner(rows, columns) * x.head(columns);
    EXPECT_LT((sum.head(rows) - expected - VecX::Constant(rows, kGuard)).norm(), 1e-12);
    EXPECT_TRUE((sum.tail(kStride - rows).array() == kGuard).all());
  });
}

TEST_P(DenseKernelsTest, AddListed) {
  const std::vector<int> listed = {39, 0, 7, 7, 12};
  forEachSize([&](int rows, int) {
    const VecX x = VecX::Random(5);
    VecX sum = VecX::Constant(kStride, kGuard), expected = sum;
    kernels.addListed(matrix.data(), kStride, rows, listed.data(), x.data(), 5, sum.data());
    for (int k = 0; k < 5; ++k)
      expected.head(rows) += x(k) * matrix.col(listed[static_cast<std::size_t>(k)]).head(rows);
    EXPECT_LT((sum - expected).norm(), 1e-12);
    EXPECT_EQ(sum.tail(kStride - rows), expected.tail(kStride - rows));
  });
}

TEST_P(DenseKernelsTest, MultiplyColumns) {
  forEachSize([&](int rows, int columns) {
    const VecX x = VecX::Random(kStride);
    VecX product = VecX::Constant(40, kGuard);
    kernels.multiplyColumns(matrix.data(), kStride, rows, x.data(), columns, product.data());
    const VecX expected = matrix.topLeftCorner(rows, columns).transpose() * x.head(rows);
    EXPECT_LT((product.head(columns) - expected).norm(), 1e-12);
    EXPECT_TRUE((product.tail(40 - columns).array() == kGuard).all());
  });
}

TEST_P(DenseKernelsTest, SubtractOuter) {
  forEachSize([&](int rows, int columns) {
    const VecX x = VecX::Random(kStride), y = VecX::Random(40);
    MatX changed = matrix, expected = matrix;
    kernels.subtractOuter(changed.data(), kStride, rows, x.data(), y.data(), columns);
    expected.topLeftCorner(rows, columns) -= x.head(rows) * y.head(columns).transpose();
    EXPECT_LT((changed - expected).norm(), 1e-12);
    EXPECT_EQ(changed.rightCols(40 - columns), matrix.rightCols(40 - columns));
    EXPECT_EQ(changed.bottomRows(kStride - rows), matrix.bottomRows(kStride - rows));
  });
}

TEST_P(DenseKernelsTest, Rotate) {
  forEachSize([&](int rows, int) {
    MatX pair = matrix.leftCols(2);
    const double c = 0.6, s = -0.8;
    kernels.rotate(pair.data(), pair.data() + kStride, rows, c, s);
    MatX expected = matrix.leftCols(2);
    expected.col(0).head(rows) = c * matrix.col(0).head(rows) + s * matrix.col(1).head(rows);
    expected.col(1).head(rows) = c * matrix.col(1).head(rows) - s * matrix.col(0).head(rows);
    EXPECT_LT((pair - expected).norm(), 1e-13);
    EXPECT_EQ(pair.bottomRows(kStride - rows), expected.bottomRows(kStride - rows));
  });
}

INSTANTIATE_TEST_SUITE_P(Sets, DenseKernelsTest, testing::ValuesIn(findInstructionSets()),
                         [](const auto& set) { return std::string(nameOf(set.param)); });

}  // namespace
}  // namespace sinew
