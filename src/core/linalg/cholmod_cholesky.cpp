#include "sinew/linalg/cholmod_cholesky.h"

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

struct CholmodCholesky::Impl {
  const BlockPattern* pattern;
  cholmod_common common;
  cholmod_sparse matrix;  // a view: pattern here, values the caller's
  std::vector<int> column_start;
  std::vector<int> row;
  std::vector<int> place;  // of each degree of freedom in the permuted order
  cholmod_factor* factor = nullptr;
  cholmod_dense* solution = nullptr;  // kept by cholmod_solve2 from call to call
  cholmod_dense* workspace_y = nullptr;
  cholmod_dense* workspace_e = nullptr;
  int rows = 0;  // of the last H
  MatX half;     // L^-1 P [H^T load]
  VecX half_motion;

  Impl(const FactorPattern& factor_pattern, int max_rows)
      : pattern(&factor_pattern.matrix()),
        half(MatX::Zero(factor_pattern.size(), max_rows + 1)),
        half_motion(factor_pattern.size()) {
    cholmod_start(&common);
    common.print = 0;
    common.final_ll = 1;
    common.supernodal = CHOLMOD_AUTO;
    common.supernodal_switch = kSupernodalSwitch;
    useOneBlasThread();
    common.error_handler = nullptr;
    expandPattern();
    matrix = {};
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(pattern->size());
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
    place.resize(static_cast<std::size_t>(pattern->size()));
    for (int k = 0; k < pattern->size(); ++k) place[order[k]] = k;
  }

  ~Impl() {
    cholmod_free_dense(&solution, &common);
    cholmod_free_dense(&workspace_y, &common);
    cholmod_free_dense(&workspace_e, &common);
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }

  void expandPattern() {
    const std::vector<int>& start = pattern->columnStart();
    column_start.push_back(0);
    for (int j = 0; j < pattern->blocks(); ++j) {
      for (int c = 0; c < 3; ++c) {
        for (int k = start[j]; k < start[j + 1]; ++k) {
          for (int r = 0; r < 3; ++r) row.push_back(3 * pattern->rows()[k] + r);
        }
        column_start.push_back(static_cast<int>(row.size()));
      }
    }
  }

  // In place: the right-hand sides are read before the solution is written back.
  void solveHalf(int system, double* columns, int count) {
    const int size = pattern->size();
    cholmod_dense right{};
    right.nrow = right.d = static_cast<std::size_t>(size);
    right.ncol = static_cast<std::size_t>(count);
    right.nzmax = right.nrow * right.ncol;
    right.x = columns;
    right.xtype = CHOLMOD_REAL;
    right.dtype = CHOLMOD_DOUBLE;
    cholmod_solve2(system, factor, &right, nullptr, &solution, nullptr, &workspace_y, &workspace_e, &common);
    using Block = Eigen::Map<MatX>;
    Block(columns, size, count) = Block(static_cast<double*>(solution->x), size, count);
  }
};

CholmodCholesky::CholmodCholesky(const FactorPattern& pattern, int max_rows)
    : impl_(std::make_unique<Impl>(pattern, max_rows)) {}

CholmodCholesky::~CholmodCholesky() = default;

int CholmodCholesky::size() const {
  return impl_->pattern->size();
}

bool CholmodCholesky::factorise(const BlockMatrix& matrix) {
  impl_->matrix.x = const_cast<double*>(matrix.values().data());
  return cholmod_factorize(&impl_->matrix, impl_->factor, &impl_->common) != 0 && impl_->common.status == CHOLMOD_OK;
}

void CholmodCholesky::condense(const BlockRows& H, const VecX& load, Eigen::Ref<MatX> compliance,
                               Eigen::Ref<VecX> motion) {
  const int rows = impl_->rows = H.rows();
  MatX& half = impl_->half;
  half.leftCols(rows + 1).setZero();
  for (int row = 0; row < rows; ++row) {
    for (const auto* entry = H.begin(row); entry != H.end(row); ++entry) {
      for (int d = 0; d < 3; ++d) half(impl_->place[3 * entry->block + d], row) += entry->derivative[d];
    }
  }
  for (int i = 0; i < size(); ++i) half(impl_->place[i], rows) = load[i];
  impl_->solveHalf(CHOLMOD_L, half.data(), rows + 1);
  const auto Y = half.leftCols(rows);
  compliance.noalias() = Y.transpose() * Y;
  motion.noalias() = Y.transpose() * half.col(rows);
}

void CholmodCholesky::calcMotion(const VecX& force, VecX& x) {
  VecX& y = impl_->half_motion;
  y = impl_->half.col(impl_->rows);
  y.noalias() += impl_->half.leftCols(impl_->rows) * force.head(impl_->rows);
  impl_->solveHalf(CHOLMOD_Lt, y.data(), 1);
  for (int i = 0; i < size(); ++i) x[i] = y[impl_->place[i]];
}

}  // namespace sinew
