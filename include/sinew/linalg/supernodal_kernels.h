#pragma once

#include <cstdint>

#include "sinew/linalg/instruction_set.h"

namespace sinew {

/// The inner loops of `SupernodalCholesky`, compiled once per instruction set. Everything is column-major; panels and
/// half solutions are readable for a few vectors beyond their end.
struct SupernodalKernels {
  /// target -= L L_head^T: what a finished panel takes from one that depends on it. `source` is the finished panel from
  /// the first row on that lies in the target's own columns; `place[i]` is where its i-th node (three rows) begins
  /// among the target's rows, and the first `column_nodes` of them are columns too.
  void (*update)(const double* source, int source_stride, int depth, const int* place, int nodes, int column_nodes,
                 double* target, int target_stride);
  /// panel <- its Cholesky factor: the lower triangle of the top square, and the rows below it. False where a pivot is
  /// not positive. Writes one reciprocal of the diagonal per column.
  bool (*factorise)(double* panel, int stride, int columns, int rows, double* inverse_diagonal);
  /// Forward substitution with one panel, for many right-hand sides at once: `half` holds a right-hand side per row and
  /// a degree of freedom per column; only the groups of `group` rows that have their bit set in `active` are not zero.
  /// `below[i]` is the node (three columns) that the i-th node of the panel's rows below its square is.
  void (*forward)(const double* panel, int stride, int columns, const double* inverse_diagonal, const int* below,
                  int below_nodes, double* half, int half_stride, int first_column, std::uint64_t active, int group);
  /// gram -= Z Z^T, lower triangle, of the active rows of `depth` columns Z of the half solutions.
  void (*product)(const double* half, int half_stride, int depth, std::uint64_t active, int group, double* gram,
                  int gram_stride);
  /// result_j = sum_i factor_i half_ij over the active rows
  void (*combine)(const double* half, int half_stride, std::uint64_t active, int group, const double* factor,
                  int columns, double* result);
  /// Backward substitution with one panel: x of its columns from theirs and those below. `gathered` takes the rows.
  void (*backward)(const double* panel, int stride, int columns, const double* inverse_diagonal, const int* below,
                   int below_nodes, double* x, int first_column, double* gathered);
};

const SupernodalKernels& kernelsOf(InstructionSet set);

}  // namespace sinew
