#include "sinew/linalg/sparse_cholesky.h"

#include <cholmod.h>
#include <dlfcn.h>

#include <stdexcept>
#include <vector>

namespace sinew {
namespace {

// At these block sizes a second BLAS thread costs more than it gives, and its waiting would disturb the control loop.
void useOneBlasThread() {
  using SetThreads = void (*)(int);
  const auto set_threads = reinterpret_cast<SetThreads>(dlsym(RTLD_DEFAULT, "openblas_set_num_threads"));
  if (set_threads != nullptr) set_threads(1);
}

// Operations per non-zero of the factor above which dense kernels pay for their calls; CHOLMOD's own default of 40
// makes the factor of a trunk of 1500 degrees of freedom take twice as long.
constexpr double kSupernodalSwitch = 400;

}  // namespace

struct SparseCholesky::Impl {
  cholmod_common common;
  cholmod_sparse matrix;  // a view: pattern here, values the caller's
  std::vector<int> column_start;
  std::vector<int> row;
  std::vector<int> place;  // of each degree of freedom in the permuted order
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;  // kept by cholmod_solve2 from call to call
  cholmod_dense* workspace_y = nullptr;
  cholmod_dense* workspace_e = nullptr;
  VecX half;  // one permuted right-hand side

  explicit Impl(const BlockPattern& pattern) {
    cholmod_start(&common);
    common.print = 0;
    common.final_ll = 1;
    common.supernodal = CHOLMOD_AUTO;
    common.supernodal_switch = kSupernodalSwitch;
    useOneBlasThread();
    common.error_handler = nullptr;
    expandPattern(pattern);
    matrix = {};
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(pattern.size());
    matrix.nzmax = row.size();
    matrix.p = column_start.data();
    matrix.i = row.data();
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = CHOLMOD_REAL;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = 1;
    matrix.packed = 1;
    std::vector<double> values(row.size(), 0.0);
    matrix.x = values.data();
    factor = cholmod_analyze(&matrix, &common);
    if (factor == nullptr) throw std::runtime_error("sparse Cholesky: symbolic analysis failed");
    const int* order = static_cast<const int*>(factor->Perm);
    place.resize(static_cast<std::size_t>(pattern.size()));
    for (int k = 0; k < pattern.size(); ++k) place[order[k]] = k;
    half.resize(pattern.size());
  }

  ~Impl() {
    cholmod_free_dense(&solution, &common);
    cholmod_free_dense(&workspace_y, &common);
    cholmod_free_dense(&workspace_e, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }

  void expandPattern(const BlockPattern& pattern) {
    const std::vector<int>& start = pattern.columnStart();
    column_start.push_back(0);
    for (int j = 0; j < pattern.blocks(); ++j) {
      for (int c = 0; c < 3; ++c) {
        for (int k = start[j]; k < start[j + 1]; ++k) {
          for (int r = 0; r < 3; ++r) row.push_back(3 * pattern.rows()[k] + r);
        }
        column_start.push_back(static_cast<int>(row.size()));
      }
    }
  }

  // In place: the right-hand sides are read before the solution is written back.
  void solveHalf(int system, double* columns, int rows, int count) {
    cholmod_dense right{};
    right.nrow = right.d = static_cast<std::size_t>(rows);
    right.ncol = static_cast<std::size_t>(count);
    right.nzmax = right.nrow * right.ncol;
    right.x = columns;
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(system, factor, &right, nullptr, &solution, nullptr, &workspace_y, &workspace_e, &common);
    using Block = Eigen::Map<MatX>;
    Block(columns, rows, count) = Block(static_cast<double*>(solution->x), rows, count);
  }
};

SparseCholesky::SparseCholesky(const BlockPattern& pattern) : impl_(std::make_unique<Impl>(pattern)) {}

SparseCholesky::~SparseCholesky() = default;

int SparseCholesky::size() const {
  return static_cast<int>(impl_->matrix.nrow);
}

bool SparseCholesky::factorise(const BlockMatrix& matrix) {
  impl_->matrix.x = const_cast<double*>(matrix.values().data());
  return cholmod_factorize(&impl_->matrix, impl_->factor, &impl_->common) != 0 && impl_->common.status == CHOLMOD_OK;
}

int SparseCholesky::permuted(int i) const {
  return impl_->place[i];
}

void SparseCholesky::forwardSolve(MatX& columns, int count) {
  if (count > 0) impl_->solveHalf(CHOLMOD_L, columns.data(), size(), count);
}

void SparseCholesky::backwardSolve(const VecX& y, VecX& x) {
  impl_->half = y;
  impl_->solveHalf(CHOLMOD_Lt, impl_->half.data(), size(), 1);
  for (int i = 0; i < size(); ++i) x[i] = impl_->half[impl_->place[i]];
}

void SparseCholesky::solve(VecX& x) {
  VecX& half = impl_->half;
  for (int i = 0; i < size(); ++i) half[impl_->place[i]] = x[i];
  impl_->solveHalf(CHOLMOD_L, half.data(), size(), 1);
  impl_->solveHalf(CHOLMOD_Lt, half.data(), size(), 1);
  for (int i = 0; i < size(); ++i) x[i] = half[impl_->place[i]];
}

double SparseCholesky::factorNonZeros() const {
  return impl_->common.lnz;
}

bool SparseCholesky::supernodal() const {
  return impl_->factor->is_super != 0;
}

}  // namespace sinew
