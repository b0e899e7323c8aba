#include "sinew/linalg/block_matrix.h"

#include <algorithm>

namespace sinew {
namespace {

using Panel = Eigen::Map<const Mat3, 0, Eigen::OuterStride<>>;

Panel blockAt(const AlignedVector<double>& values, int first, int stride) {
  return Panel(values.data() + first, Eigen::OuterStride<>(stride));
}

}  // namespace

BlockPattern::BlockPattern(int blocks, const std::vector<std::vector<int>>& cliques) {
  std::vector<std::vector<int>> columns(static_cast<std::size_t>(blocks));
  for (int j = 0; j < blocks; ++j) columns[j].push_back(j);
  for (const std::vector<int>& clique : cliques) {
    for (int row : clique) {
      for (int column : clique) {
        if (column >= 0 && row > column) columns[column].push_back(row);
      }
    }
  }
  column_start_.assign(1, 0);
  for (std::vector<int>& rows : columns) {
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    row_.insert(row_.end(), rows.begin(), rows.end());
    column_start_.push_back(static_cast<int>(row_.size()));
  }
}

BlockPattern BlockPattern::renumbered(const std::vector<int>& order) const {
  std::vector<int> place(order.size());
  for (std::size_t k = 0; k < order.size(); ++k) place[order[k]] = static_cast<int>(k);
  std::vector<std::vector<int>> pairs;
  for (int j = 0; j < blocks(); ++j) {
    for (int k = column_start_[j] + 1; k < column_start_[j + 1]; ++k) pairs.push_back({place[j], place[row_[k]]});
  }
  return BlockPattern(blocks(), pairs);
}

BlockSlot BlockPattern::slot(int row, int column) const {
  const int start = column_start_[column];
  const int end = column_start_[column + 1];
  const auto found = std::lower_bound(row_.begin() + start, row_.begin() + end, row);
  const int place = static_cast<int>(found - row_.begin()) - start;
  return {9 * start + 3 * place, 3 * (end - start)};
}

BlockMatrix::BlockMatrix(const BlockPattern& pattern)
    : pattern_(&pattern), values_(static_cast<std::size_t>(9 * pattern.blockCount()), 0.0) {}

void BlockMatrix::setZero() {
  std::fill(values_.begin(), values_.end(), 0.0);
}

void BlockMatrix::scale(double factor) {
  for (double& value : values_) value *= factor;
}

void BlockMatrix::addProduct(double factor, const VecX& x, VecX& y) const {
  const std::vector<int>& start = pattern_->columnStart();
  for (int j = 0; j < pattern_->blocks(); ++j) {
    const int stride = 3 * (start[j + 1] - start[j]);
    const Vec3 xj = factor * x.segment<3>(3 * j);
    y.segment<3>(3 * j) += blockAt(values_, 9 * start[j], stride) * xj;
    for (int k = start[j] + 1; k < start[j + 1]; ++k) {
      const int i = pattern_->rows()[k];
      const Panel block = blockAt(values_, 9 * start[j] + 3 * (k - start[j]), stride);
      y.segment<3>(3 * i) += block * xj;
      y.segment<3>(3 * j) += factor * (block.transpose() * x.segment<3>(3 * i));
    }
  }
}

MatX BlockMatrix::makeDense() const {
  const std::vector<int>& start = pattern_->columnStart();
  MatX dense = MatX::Zero(pattern_->size(), pattern_->size());
  for (int j = 0; j < pattern_->blocks(); ++j) {
    const int stride = 3 * (start[j + 1] - start[j]);
    for (int k = start[j]; k < start[j + 1]; ++k) {
      const int i = pattern_->rows()[k];
      const Panel block = blockAt(values_, 9 * start[j] + 3 * (k - start[j]), stride);
      dense.block<3, 3>(3 * i, 3 * j) = block;
      dense.block<3, 3>(3 * j, 3 * i) = block.transpose();
    }
  }
  return dense;
}

}  // namespace sinew
