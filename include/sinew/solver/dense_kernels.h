#pragma once

#include "sinew/linalg/instruction_set.h"

namespace sinew {

/// Products with the columns of a small dense matrix, once per instruction set. Columns are `rows` long and `stride`
/// apart.
struct DenseKernels {
  /// sum += M x
  void (*addColumns)(const double* matrix, int stride, int rows, const double* x, int columns, double* sum);
  /// The same with the columns `listed`, `count` of them: sum += M(:, listed) x
  void (*addListed)(const double* matrix, int stride, int rows, const int* listed, const double* x, int count,
                    double* sum);
  /// product = M^T x
  void (*multiplyColumns)(const double* matrix, int stride, int rows, const double* x, int columns, double* product);
  /// M -= x y^T
  void (*subtractOuter)(double* matrix, int stride, int rows, const double* x, const double* y, int columns);
  /// (left, right) <- (c left + s right, c right - s left)
  void (*rotate)(double* left, double* right, int rows, double c, double s);
};

const DenseKernels& denseKernelsOf(InstructionSet set);

}  // namespace sinew
