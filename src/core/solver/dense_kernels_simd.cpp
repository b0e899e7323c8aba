#include "sinew/linalg/simd.h"
#include "sinew/solver/dense_kernels.h"

#define SINEW_UNROLL _Pragma("GCC unroll 8")

namespace sinew {
namespace SINEW_ISA {
namespace {

constexpr int kWidth = Simd::kWidth;
constexpr int kAtOnce = 4;  // vectors of rows, or columns: enough to hide what a product waits for

Simd loadUpTo(const double* from, int count) {
  return count >= kWidth ? Simd::load(from) : Simd::loadHead(from, count);
}

void storeUpTo(Simd value, double* to, int count) {
  if (count >= kWidth) {
    value.store(to);
  } else {
    value.storeHead(to, count);
  }
}

/// sum += the columns that `at` gives, times x
template <typename At>
void addScaled(const At& at, int rows, const double* x, int count, double* sum) {
  int r = 0;
  for (; r + kAtOnce * kWidth <= rows; r += kAtOnce * kWidth) {
    Simd total[kAtOnce];
    SINEW_UNROLL for (int v = 0; v < kAtOnce; ++v) total[v] = Simd::load(sum + r + v * kWidth);
    for (int j = 0; j < count; ++j) {
      const double* column = at(j) + r;
      const Simd factor = Simd::fill(x[j]);
      SINEW_UNROLL for (int v = 0; v < kAtOnce; ++v) {
        total[v] = multiplyAdd(Simd::load(column + v * kWidth), factor, total[v]);
      }
    }
    SINEW_UNROLL for (int v = 0; v < kAtOnce; ++v) total[v].store(sum + r + v * kWidth);
  }
  for (; r < rows; r += kWidth) {
    Simd total = loadUpTo(sum + r, rows - r);
    for (int j = 0; j < count; ++j) total = multiplyAdd(loadUpTo(at(j) + r, rows - r), Simd::fill(x[j]), total);
    storeUpTo(total, sum + r, rows - r);
  }
}

void addColumns(const double* matrix, int stride, int rows, const double* x, int columns, double* sum) {
  addScaled([=](int j) { return matrix + j * stride; }, rows, x, columns, sum);
}

void addListed(const double* matrix, int stride, int rows, const int* listed, const double* x, int count, double* sum) {
  addScaled([=](int j) { return matrix + listed[j] * stride; }, rows, x, count, sum);
}

void multiplyColumns(const double* matrix, int stride, int rows, const double* x, int columns, double* product) {
  int j = 0;
  for (; j + kAtOnce <= columns; j += kAtOnce) {
    const double* column = matrix + j * stride;
    Simd total[kAtOnce] = {Simd::fill(0), Simd::fill(0), Simd::fill(0), Simd::fill(0)};
    for (int r = 0; r < rows; r += kWidth) {
      const Simd factor = loadUpTo(x + r, rows - r);
      SINEW_UNROLL for (int v = 0; v < kAtOnce; ++v) {
        total[v] = multiplyAdd(loadUpTo(column + r + v * stride, rows - r), factor, total[v]);
      }
    }
    for (int v = 0; v < kAtOnce; ++v) product[j + v] = sum(total[v]);
  }
  for (; j < columns; ++j) {
    Simd total = Simd::fill(0);
    for (int r = 0; r < rows; r += kWidth) {
      total = multiplyAdd(loadUpTo(matrix + r + j * stride, rows - r), loadUpTo(x + r, rows - r), total);
    }
    product[j] = sum(total);
  }
}

void subtractOuter(double* matrix, int stride, int rows, const double* x, const double* y, int columns) {
  for (int j = 0; j < columns; ++j, matrix += stride) {
    const Simd factor = Simd::fill(y[j]);
    for (int r = 0; r < rows; r += kWidth) {
      const int count = rows - r;
      storeUpTo(multiplySubtract(loadUpTo(x + r, count), factor, loadUpTo(matrix + r, count)), matrix + r, count);
    }
  }
}

void rotate(double* left, double* right, int rows, double c, double s) {
  const Simd cosine = Simd::fill(c), sine = Simd::fill(s);
  for (int r = 0; r < rows; r += kWidth) {
    const int count = rows - r;
    const Simd a = loadUpTo(left + r, count), b = loadUpTo(right + r, count);
    storeUpTo(multiplyAdd(cosine, a, sine * b), left + r, count);
    storeUpTo(multiplySubtract(sine, a, cosine * b), right + r, count);
  }
}

}  // namespace

const DenseKernels& denseKernels() {
  static const DenseKernels kernels = {addColumns, addListed, multiplyColumns, subtractOuter, rotate};
  return kernels;
}

}  // namespace SINEW_ISA
}  // namespace sinew
