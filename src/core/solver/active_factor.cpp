#include "sinew/solver/active_factor.h"

#include <Eigen/Householder>
#include <Eigen/Jacobi>
#include <cmath>

namespace sinew {

namespace {
/// Pivots below this share of the diagonal of G count as zero: what rounding leaves of them.
constexpr double kFlatPivot = 1e-12;
}  // namespace

ActiveFactor::ActiveFactor(int max_variables)
    : J_(max_variables, max_variables),
      R_(max_variables, max_variables),
      cholesky_(max_variables, max_variables),
      proximal_(max_variables),
      projected_(max_variables),
      work_(max_variables) {}

void ActiveFactor::reset(const Eigen::Ref<const MatX>& G, double lift) {
  variables_ = static_cast<int>(G.cols());
  size_ = 0;
  lifted_ = false;
  for (int j = 0; j < variables_; ++j) {
    auto u = cholesky_.col(j).head(j);
    u = G.col(j).head(j);
    cholesky_.topLeftCorner(j, j).triangularView<Eigen::Upper>().transpose().solveInPlace(u);
    const double pivot = G(j, j) - u.squaredNorm();
    const bool flat = !(pivot > kFlatPivot * G(j, j));
    const double root = std::sqrt(flat ? lift : pivot);
    proximal_(j) = flat ? lift - pivot : 0;
    lifted_ = lifted_ || flat;
    cholesky_(j, j) = root;

    // Column j of J = U^-1.
    auto above = J_.col(j).head(j);
    above = u * (-1 / root);
    cholesky_.topLeftCorner(j, j).triangularView<Eigen::Upper>().solveInPlace(above);
    J_(j, j) = 1 / root;
    J_.col(j).segment(j + 1, variables_ - j - 1).setZero();
  }
}

void ActiveFactor::project(const Eigen::Ref<const VecX>& normal) {
  projected_.head(variables_).noalias() = J_.topLeftCorner(variables_, variables_).transpose() * normal;
}

void ActiveFactor::project(int unknown) {
  projected_.head(variables_) = J_.row(unknown).head(variables_).transpose();
}

bool ActiveFactor::dependent(double tolerance) const {
  return free().squaredNorm() <= tolerance * tolerance * projected_.head(variables_).squaredNorm();
}

void ActiveFactor::calcPrimalDirection(Eigen::Ref<VecX> z) const {
  z.noalias() = J_.block(0, size_, variables_, variables_ - size_) * free();
}

void ActiveFactor::calcDualDirection(Eigen::Ref<VecX> r) const {
  r = fixed();
  R_.topLeftCorner(size_, size_).triangularView<Eigen::Upper>().solveInPlace(r);
}

void ActiveFactor::append() {
  const int rest = variables_ - size_;
  double factor = 0;
  double length = 0;
  auto tail = projected_.segment(size_, rest);
  tail.makeHouseholderInPlace(factor, length);
  J_.block(0, size_, variables_, rest).applyHouseholderOnTheRight(tail.tail(rest - 1), factor, work_.data());
  R_.col(size_).head(size_) = fixed();
  R_(size_, size_) = length;
  ++size_;
}

void ActiveFactor::remove(int position) {
  for (int k = position + 1; k < size_; ++k) R_.col(k - 1).head(k + 1) = R_.col(k).head(k + 1);
  --size_;
  for (int k = position; k < size_; ++k) {
    Eigen::JacobiRotation<double> rotation;
    rotation.makeGivens(R_(k, k), R_(k + 1, k));
    R_.block(k, k, 2, size_ - k).applyOnTheLeft(0, 1, rotation.adjoint());
    J_.topRows(variables_).applyOnTheRight(k, k + 1, rotation);
  }
}

void ActiveFactor::solve(const Eigen::Ref<const VecX>& dual_residual, const Eigen::Ref<const VecX>& primal_residual,
                         Eigen::Ref<VecX> dx, Eigen::Ref<VecX> du) {
  const auto R = R_.topLeftCorner(size_, size_).triangularView<Eigen::Upper>();
  auto v = work_.head(variables_);
  v.noalias() = J_.topLeftCorner(variables_, variables_).transpose() * dual_residual;
  du = -v.head(size_);
  v.head(size_) = primal_residual;
  R.transpose().solveInPlace(v.head(size_));
  du += v.head(size_);
  R.solveInPlace(du);
  dx.noalias() = J_.topLeftCorner(variables_, variables_) * v;
}

}  // namespace sinew
