#include "sinew/linalg/factor_pattern.h"

#include <algorithm>
#include <iterator>

namespace sinew {
namespace {

constexpr int kLine = 8;  // doubles in a cache line

/// Whole cache lines, an odd number of them: columns an even number apart would share few places of the cache.
int padStride(int rows) {
  const int lines = (rows + kLine - 1) / kLine;
  return kLine * (lines + (lines % 2 == 0 ? 1 : 0));
}

}  // namespace

FactorPattern::FactorPattern(BlockPattern matrix, const std::vector<int>& panel_start)
    : matrix_(std::move(matrix)), panel_of_(static_cast<std::size_t>(matrix_.blocks())) {
  for (std::size_t p = 0; p + 1 < panel_start.size(); ++p) {
    panels_.push_back({panel_start[p], panel_start[p + 1] - panel_start[p], 0, 0, 0, 0, -1});
    std::fill(panel_of_.begin() + panel_start[p], panel_of_.begin() + panel_start[p + 1], static_cast<int>(p));
  }
  findRows();
  findUpdates();

  for (int j = 0; j < matrix_.blocks(); ++j) {
    for (int k = matrix_.columnStart()[j]; k < matrix_.columnStart()[j + 1]; ++k) {
      matrix_places_.push_back(3 * placeInPanel(panels_[panel_of_[j]], matrix_.rows()[k]));
    }
  }
}

int FactorPattern::placeInPanel(const Panel& panel, int block) const {
  if (block < panel.first + panel.own) return block - panel.first;
  const auto begin = below_.begin() + panel.below_begin;
  return panel.own + static_cast<int>(std::lower_bound(begin, begin + panel.below_count, block) - begin);
}

// Rows below a panel: the matrix's own, and what the panels whose parent it is have left.
void FactorPattern::findRows() {
  std::vector<std::vector<int>> rows(panels_.size());
  for (std::size_t p = 0; p < panels_.size(); ++p) {
    Panel& panel = panels_[p];
    const int end = panel.first + panel.own;
    std::vector<int>& mine = rows[p];
    for (int j = panel.first; j < end; ++j) {
      const auto begin = matrix_.rows().begin() + matrix_.columnStart()[j];
      std::copy_if(begin, matrix_.rows().begin() + matrix_.columnStart()[j + 1], std::back_inserter(mine),
                   [end](int row) { return row >= end; });
    }
    std::sort(mine.begin(), mine.end());
    mine.erase(std::unique(mine.begin(), mine.end()), mine.end());
    if (!mine.empty()) {
      panel.parent = panel_of_[mine.front()];
      const Panel& parent = panels_[panel.parent];
      const auto beyond = std::lower_bound(mine.begin(), mine.end(), parent.first + parent.own);
      rows[panel.parent].insert(rows[panel.parent].end(), beyond, mine.end());
    }
    panel.below_begin = static_cast<int>(below_.size());
    panel.below_count = static_cast<int>(mine.size());
    below_.insert(below_.end(), mine.begin(), mine.end());
    panel.values = value_count_;
    panel.stride = padStride(panel.rows());
    value_count_ += panel.columns() * panel.stride;
    std::vector<int>().swap(mine);
  }
}

void FactorPattern::findUpdates() {
  std::vector<std::vector<Update>> of_target(panels_.size());
  for (int source = 0; source < static_cast<int>(panels_.size()); ++source) {
    const Panel& from = panels_[source];
    for (int row = 0; row < from.below_count;) {
      const int target = panel_of_[below_[from.below_begin + row]];
      const int first = row;
      while (row < from.below_count && panel_of_[below_[from.below_begin + row]] == target) ++row;
      of_target[target].push_back({source, first, row - first, static_cast<int>(places_.size())});
      for (int k = first; k < from.below_count; ++k) {
        places_.push_back(3 * placeInPanel(panels_[target], below_[from.below_begin + k]));
      }
    }
  }
  update_start_.push_back(0);
  for (const std::vector<Update>& updates : of_target) {
    updates_.insert(updates_.end(), updates.begin(), updates.end());
    update_start_.push_back(static_cast<int>(updates_.size()));
  }
}

}  // namespace sinew
