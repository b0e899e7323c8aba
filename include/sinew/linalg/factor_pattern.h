#pragma once

#include <cstddef>
#include <vector>

#include "sinew/linalg/block_matrix.h"

namespace sinew {

/// Block sparsity of a Cholesky factor in panels. A panel holds some consecutive block columns as one dense
/// column-major array: their own square on top, below it every block row in which one of them has an entry. The matrix
/// is assembled into the places that its factor will take: `matrix()` has its slots there.
class FactorPattern {
 public:
  struct Panel {
    int first;        ///< block
    int own;          ///< blocks of columns
    int below_begin;  ///< into `below()`
    int below_count;  ///< blocks of rows under the square
    int values;       ///< of its first entry in the storage
    int stride;       ///< from column to column
    int parent;       ///< the panel of its first row below, -1 for a root
    int columns() const { return 3 * own; }
    int rows() const { return 3 * (own + below_count); }
  };
  /// What a panel takes from one that was finished before it.
  struct Update {
    int source;        ///< panel
    int first_row;     ///< the first of the source's blocks below that lies in the target's own columns
    int column_count;  ///< blocks of them that do
    int place;         ///< into `places()`: where each block from there on begins among the target's rows
  };

  /// `matrix` is in the order of elimination; `panel_start` cuts it (see Elimination).
  FactorPattern(BlockPattern matrix, const std::vector<int>& panel_start);
  const BlockPattern& matrix() const { return matrix_; }
  int size() const { return matrix_.size(); }
  int valueCount() const { return value_count_; }  ///< doubles that the panels take

  const std::vector<Panel>& panels() const { return panels_; }
  const std::vector<int>& below() const { return below_; }  ///< blocks, ascending in each panel
  const std::vector<int>& places() const { return places_; }
  /// Of every block of the matrix, in its order: where it begins among the rows of its panel.
  const std::vector<int>& matrixPlaces() const { return matrix_places_; }
  const Update* updatesBegin(int panel) const { return updates_.data() + update_start_[panel]; }
  const Update* updatesEnd(int panel) const { return updates_.data() + update_start_[panel + 1]; }
  int panelOf(int block) const { return panel_of_[block]; }

 private:
  void findRows();
  void findUpdates();
  int placeInPanel(const Panel& panel, int block) const;

  BlockPattern matrix_;
  std::vector<int> panel_of_;
  std::vector<Panel> panels_;
  std::vector<int> below_;
  std::vector<int> update_start_;
  std::vector<Update> updates_;
  std::vector<int> places_;
  std::vector<int> matrix_places_;
  int value_count_ = 0;
};

}  // namespace sinew
