#include "sinew/inverse/forward_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

ForwardProblem::ForwardProblem(const VecX& effort_min, int max_contacts)
    : effort_min_(effort_min),
      actuators_(static_cast<int>(effort_min.size())),
      scale_(actuators_ + max_contacts),
      x_(actuators_ + max_contacts),
      change_(VecX::Zero(actuators_ + max_contacts)),
      gap_(max_contacts),
      problem_(actuators_ + max_contacts),
      gauss_seidel_(actuators_ + max_contacts),
      qp_problem_(actuators_ + max_contacts, 0),
      qp_solution_(actuators_ + max_contacts, 0),
      qp_(actuators_ + max_contacts, 0) {
  const auto most = static_cast<std::size_t>(actuators_) + static_cast<std::size_t>(max_contacts);
  unknowns_.reserve(most);
  rows_.reserve(most);
}

// Everything that is no unknown goes to where it is given, and every unknown to the least it can be.
bool ForwardProblem::gatherRows(const Eigen::Ref<const MatX>& W, int first_contact, const VecX& effort,
                                const Actuation& actuation) {
  unknowns_.clear();
  rows_.clear();
  for (int i = 0; i < actuators_; ++i) {
    if (!(W(i, i) > 0)) return false;
    const bool held = actuation.mode[i] == Actuation::Mode::kDisplacement;
    const bool bounded = std::isfinite(effort_min_[i]);
    change_[i] = held ? (bounded ? effort_min_[i] - effort[i] : 0) : actuation.value[i] - effort[i];
    if (!held) continue;
    problem_.equality[unknowns_.size()] = !bounded;
    unknowns_.push_back(i);
    rows_.push_back(i);
  }
  problem_.block = static_cast<int>(rows_.size());
  for (int i = 0; i < contacts_; ++i) {
    change_[actuators_ + i] = 0;
    problem_.equality[unknowns_.size()] = false;
    unknowns_.push_back(actuators_ + i);
    rows_.push_back(first_contact + i);
  }
  problem_.size = static_cast<int>(rows_.size());
  return true;
}

void ForwardProblem::gatherProblem(const Eigen::Ref<const MatX>& W, const Vector& displacement, const Vector& gap,
                                   const Actuation& actuation, const Vector& guess) {
  for (int k = 0; k < problem_.size; ++k) {
    const double own = W(rows_[k], rows_[k]);
    scale_[k] = own > 0 ? 1 / std::sqrt(own) : 1.0;  // nothing gives way to a contact of fixed nodes only
  }
  for (int j = 0; j < problem_.size; ++j) {
    for (int i = 0; i < problem_.size; ++i) problem_.A(i, j) = scale_[i] * scale_[j] * W(rows_[i], rows_[j]);
    const bool cable = j < problem_.block;
    const int own = unknowns_[j], contact = own - actuators_;
    const double level = cable ? displacement[own] - actuation.value[own] : gap[contact];
    problem_.b[j] = scale_[j] * (level + W.row(rows_[j]).head(actuators_).dot(change_.head(actuators_)));
    x_[j] = (cable ? -change_[own] : guess[contact]) / scale_[j];
  }
}

QpStatus ForwardProblem::solveAsQp() {
  const int size = problem_.size;
  qp_problem_.resize(size, 0);
  qp_problem_.G.topLeftCorner(size, size) = problem_.A.topLeftCorner(size, size);
  qp_problem_.G.diagonal().head(size).array() += ComplementarityGaussSeidel::kLift;
  qp_problem_.g.head(size) = problem_.b.head(size);
  for (int k = 0; k < size; ++k) {
    qp_problem_.lower[k] = problem_.equality[k] ? -std::numeric_limits<double>::infinity() : 0.0;
  }
  qp_problem_.upper.head(size).setConstant(std::numeric_limits<double>::infinity());
  const QpStatus status = qp_.solve(qp_problem_, qp_solution_);
  iterations_ += qp_solution_.iterations;
  if (status == QpStatus::kSolved) x_.head(size) = qp_solution_.x.head(size);
  return status;
}

QpStatus ForwardProblem::solveProblem() {
  const ComplementarityStatus status = gauss_seidel_.solve(problem_, x_.head(problem_.size));
  iterations_ = gauss_seidel_.directSolves();
  if (status == ComplementarityStatus::kNotFinite) return QpStatus::kNotFinite;
  return status == ComplementarityStatus::kSolved ? QpStatus::kSolved : solveAsQp();
}

QpStatus ForwardProblem::solve(const Eigen::Ref<const MatX>& W, int first_contact, const Vector& displacement,
                               const Vector& gap, const VecX& effort, const Actuation& actuation, const Vector& guess) {
  contacts_ = static_cast<int>(gap.size());
  iterations_ = 0;
  if (!gatherRows(W, first_contact, effort, actuation)) return QpStatus::kNotFinite;
  gatherProblem(W, displacement, gap, actuation, guess);
  const QpStatus status = solveProblem();
  if (status != QpStatus::kSolved) return status;
  for (int k = 0; k < problem_.size; ++k) change_[unknowns_[k]] += scale_[k] * x_[k];
  if (!change_.head(actuators_ + contacts_).allFinite()) return QpStatus::kNotFinite;
  for (int i = 0; i < contacts_; ++i) {
    const int k = problem_.block + i;
    gap_[i] = (problem_.b[k] + problem_.A.col(k).head(problem_.size).dot(x_.head(problem_.size))) / scale_[k];
  }
  return QpStatus::kSolved;
}

}  // namespace sinew
