#include "sinew/solver/qpcc_relaxation.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sinew/solver/complementarity_tableau.h"

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRidges[] = {1e-10, 1e-8, 1e-6};  // curvature of x that the objective may lack, the least that does
constexpr double kLeastRho = 1e-8;
constexpr double kEnoughRho = 1e-6;  // for a smaller ridge to be kept
constexpr double kMostRho = 1e2;
constexpr double kCoarse = 8;  // factor between the first trials of rho
constexpr int kBisections = 5;
constexpr double kRounding = 1e-13;  // of a difference, against the terms
constexpr double kSafePivot = 1e-6;  // of the convexity test, against the diagonal

/// Factorises the upper triangle in place; returns whether all pivots are more than a share of their diagonal.
bool factorise(Eigen::Ref<MatX> A, double least_share) {
  for (int j = 0; j < A.cols(); ++j) {
    auto u = A.col(j).head(j);
    for (int i = 0; i < j; ++i) u(i) = (u(i) - A.col(i).head(i).dot(u.head(i))) / A(i, i);
    const double pivot = A(j, j) - u.squaredNorm();
    if (!(pivot > least_share * A(j, j)) || !(pivot > 0)) return false;
    A(j, j) = std::sqrt(pivot);
  }
  return true;
}

/// U^T y = x in place.
void solveTransposed(const Eigen::Ref<const MatX>& U, Eigen::Ref<VecX> x) {
  for (int i = 0; i < x.size(); ++i) x(i) = (x(i) - U.col(i).head(i).dot(x.head(i))) / U(i, i);
}

}  // namespace

QpccRelaxation::QpccRelaxation(const QpccSizes& capacity, InstructionSet set)
    : kernels_(&denseKernelsOf(set)),
      map_(capacity.contacts + capacity.rows, capacity.contacts + capacity.unknowns + 1),
      E_(capacity.contacts + capacity.unknowns, capacity.effectors),
      G_(capacity.contacts + capacity.unknowns, capacity.contacts + capacity.unknowns),
      g_(capacity.contacts + capacity.unknowns),
      factor_(capacity.contacts + capacity.unknowns + capacity.effectors, capacity.contacts),
      row_(capacity.contacts),
      gram_(capacity.unknowns + capacity.effectors, capacity.unknowns + capacity.effectors),
      K_gram_(capacity.unknowns, capacity.unknowns),
      F_K_(capacity.effectors, capacity.unknowns),
      schur_(capacity.unknowns, capacity.unknowns),
      small_(capacity.effectors, capacity.effectors),
      limits_(capacity.contacts + capacity.rows + capacity.contacts + capacity.unknowns) {}

bool QpccRelaxation::prepare(const ScaledQpcc& problem, QpInterruption* interruption) {
  problem_ = &problem;
  const int m = problem.limitedRows();
  map_.topLeftCorner(m, problem.tableColumns()) = problem.table.topLeftCorner(m, problem.tableColumns());
  map_.topLeftCorner(problem.size.contacts, problem.size.contacts).diagonal().array() += ComplementarityTableau::kLift;
  if (!updateGrams(interruption)) return false;
  rho_ = 0;
  for (const double ridge : kRidges) {
    if (interruption && interruption->due()) return false;
    ridge_ = ridge;
    rho_ = findLargestRho();
    if (rho_ > kEnoughRho) break;
  }
  if (rho_ == 0) return false;
  updateLimits();
  return updateObjective(interruption);
}

QpRows QpccRelaxation::rows() const {
  return makeQpRows(map_.leftCols(problem_->tableColumns()), problem_->limitedRows());
}

bool QpccRelaxation::start(DualQp& qp, const std::vector<char>& open, QpInterruption* interruption) const {
  const int n = problem_->size.contacts + problem_->size.unknowns;
  return qp.start(G_.topLeftCorner(n, n), g_.head(n), open, interruption);
}

/// Rows below the square take part in its factorisation, which solves for them.
bool QpccRelaxation::updateGrams(QpInterruption* interruption) {
  const ScaledQpcc& p = *problem_;
  const int nc = p.size.contacts;
  const int na = p.size.unknowns;
  const int ne = p.size.effectors;
  const int all = nc + na + ne;
  factor_.topLeftCorner(nc, nc) = map_.topLeftCorner(nc, nc);
  factor_.block(nc, 0, na, nc) = map_.block(0, nc, nc, na).transpose();
  factor_.block(nc + na, 0, ne, nc) = p.table.block(p.limitedRows(), 0, ne, nc);
  for (int j = 0; j < nc; ++j) {
    if (interruption && interruption->due()) return false;
    row_.head(j) = -factor_.row(j).head(j).transpose();
    kernels_->addColumns(&factor_(j, 0), static_cast<int>(factor_.outerStride()), all - j, row_.data(), j,
                         &factor_(j, j));
    const double pivot = factor_(j, j);
    if (!(pivot > 0)) return false;
    factor_.col(j).segment(j, all - j) /= std::sqrt(pivot);
  }
  const auto X = factor_.block(nc, 0, na + ne, nc);
  gram_.topLeftCorner(na + ne, na + ne).noalias() = X.lazyProduct(X.transpose());
  return true;
}

/// In y = L^T z the Hessian is [2 rho I + F F^T, K; K^T, E_a^T E_a + Q] with B = L^-1 C_a, F = L^-1 E_c^T and
/// K = rho B + F E_a. It is positive definite where its Schur complement in x is; the inverse of the first block is
/// (I - F (2 rho I + F^T F)^-1 F^T) / (2 rho), so that products of B and F suffice.
bool QpccRelaxation::isConvex(double rho) {
  const ScaledQpcc& p = *problem_;
  const int na = p.size.unknowns;
  const int ne = p.size.effectors;
  const auto BB = gram_.topLeftCorner(na, na);
  const auto FB = gram_.block(na, 0, ne, na);
  const auto FF = gram_.block(na, na, ne, ne);
  const auto E_a = p.table.block(p.limitedRows(), p.size.contacts, ne, na);
  auto FK = F_K_.topLeftCorner(ne, na);
  auto KK = K_gram_.topLeftCorner(na, na);
  auto S = schur_.topLeftCorner(na, na);
  auto U = small_.topLeftCorner(ne, ne);

  FK = rho * FB;
  FK += FF.lazyProduct(E_a);
  KK = (rho * rho) * BB;
  KK += rho * FB.transpose().lazyProduct(E_a);
  KK += E_a.transpose().lazyProduct(FK);
  U = FF;
  U.diagonal().array() += 2 * rho;
  if (!factorise(U, 0)) return false;
  for (int j = 0; j < na; ++j) solveTransposed(U, FK.col(j));
  KK -= FK.transpose().lazyProduct(FK);

  S = p.Q.topLeftCorner(na, na);
  S += E_a.transpose().lazyProduct(E_a);
  S.diagonal().array() += ridge_;
  const double trace = S.trace();
  S -= KK / (2 * rho);
  return (S.diagonal().array() > kRounding * trace).all() && factorise(S, kSafePivot);
}

/// Zero if none will do. The set of those that do is an interval from zero, but for rounding where rho is small.
double QpccRelaxation::findLargestRho() {
  double low = kMostRho;
  while (!isConvex(low)) {
    low /= kCoarse;
    if (low < kLeastRho) return 0;
  }
  double high = low * kCoarse;
  for (int k = 0; k < kBisections; ++k) {
    const double middle = std::sqrt(low * high);
    (isConvex(middle) ? low : high) = middle;
  }
  return 0.99 * low;
}

/// C_c being symmetric, rho z^T C_c z has the Hessian 2 rho C_c.
bool QpccRelaxation::updateObjective(QpInterruption* interruption) {
  const ScaledQpcc& p = *problem_;
  const int nc = p.size.contacts;
  const int na = p.size.unknowns;
  const int ne = p.size.effectors;
  const int n = nc + na;
  const auto E = p.table.block(p.limitedRows(), 0, ne, n + 1);
  const auto C = map_.topLeftCorner(nc, n + 1);
  const auto addSquare = [&](int column, double* sum) {
    kernels_->addColumns(E_.data(), static_cast<int>(E_.outerStride()), n, E.col(column).data(), ne, sum);
  };
  E_.topLeftCorner(n, ne) = E.leftCols(n).transpose();
  for (int j = 0; j < n; ++j) {
    if (interruption && interruption->due()) return false;
    auto column = G_.col(j).head(n);
    if (j < nc) {
      column.head(nc) = (2 * rho_) * C.col(j);
      column.tail(na) = rho_ * C.block(j, nc, 1, na).transpose();
    } else {
      column.head(nc) = rho_ * C.col(j);
      column.tail(na) = p.Q.col(j - nc).head(na);
      column(j) += ridge_;
    }
    addSquare(j, column.data());
  }
  g_.head(nc) = rho_ * C.col(n);
  g_.segment(nc, na) = p.q.head(na);
  addSquare(n, g_.data());
  constant_ = 0.5 * E.col(n).squaredNorm();
  return true;
}

/// What the ridge adds to the objective at most, within the limits of x.
double QpccRelaxation::calcSlack() const {
  const int na = problem_->size.unknowns;
  const int x = problem_->limitedRows() + problem_->size.contacts;
  return 0.5 * ridge_ *
         limits_.lower.segment(x, na).cwiseAbs().cwiseMax(limits_.upper.segment(x, na).cwiseAbs()).squaredNorm();
}

void QpccRelaxation::updateLimits() {
  const ScaledQpcc& p = *problem_;
  const int nc = p.size.contacts;
  const int na = p.size.unknowns;
  const int m = p.limitedRows();
  limits_.lower.head(m) = p.row_lower.head(m);
  limits_.upper.head(m) = p.row_upper.head(m);
  limits_.lower.segment(m, nc).setZero();
  limits_.upper.segment(m, nc).setConstant(kInfinity);
  limits_.lower.segment(m + nc, na) = p.x_lower.head(na).cwiseMax(p.soft_lower.head(na));
  limits_.upper.segment(m + nc, na) = p.x_upper.head(na).cwiseMin(p.soft_upper.head(na));
}

}  // namespace sinew
