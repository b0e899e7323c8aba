#include "sinew/inverse/row_space.h"

#include <algorithm>

namespace sinew {

RowSpace::RowSpace(int max_rows, int columns)
    : remainder_(max_rows, columns), basis_(std::min(max_rows, columns), columns) {}

void RowSpace::removeBasis(int row) {
  for (int k = 0; k < rank_; ++k) {
    remainder_.row(row) -= remainder_.row(row).dot(basis_.row(k)) * basis_.row(k);
  }
}

void RowSpace::update(const MatX& matrix, int rows, double tolerance) {
  rank_ = 0;
  remainder_.topRows(rows) = matrix.topRows(rows);
  double longest = 0;
  while (rank_ < std::min<int>(rows, static_cast<int>(basis_.cols()))) {
    int pivot = 0;
    const double length = std::sqrt(remainder_.topRows(rows).rowwise().squaredNorm().maxCoeff(&pivot));
    longest = std::max(longest, length);
    if (!(length > tolerance * longest)) return;
    removeBasis(pivot);
    basis_.row(rank_) = remainder_.row(pivot) / remainder_.row(pivot).norm();
    ++rank_;
    for (int i = 0; i < rows; ++i) {
      remainder_.row(i) -= remainder_.row(i).dot(basis_.row(rank_ - 1)) * basis_.row(rank_ - 1);
    }
    remainder_.row(pivot).setZero();
  }
}

}  // namespace sinew
