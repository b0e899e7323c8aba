#pragma once

#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// Sparse rows over the degrees of freedom of a block matrix, as blocks of three: H of a compliance H A^-1 H^T.
/// Capacity fixed at set-up.
class BlockRows {
 public:
  struct Entry {
    int block;
    Vec3 derivative;
  };

  BlockRows(int max_rows, int max_entries) {
    start_.reserve(static_cast<std::size_t>(max_rows));
    entries_.reserve(static_cast<std::size_t>(max_entries));
  }

  void clear() {
    start_.clear();
    entries_.clear();
  }
  void beginRow() { start_.push_back(static_cast<int>(entries_.size())); }
  /// Adds to the last row.
  void add(int block, const Vec3& derivative) { entries_.push_back({block, derivative}); }

  int rows() const { return static_cast<int>(start_.size()); }
  const Entry* begin(int row) const { return entries_.data() + start_[row]; }
  const Entry* end(int row) const {
    return entries_.data() + (row + 1 < rows() ? start_[row + 1] : static_cast<int>(entries_.size()));
  }

 private:
  std::vector<int> start_;
  std::vector<Entry> entries_;
};

}  // namespace sinew
