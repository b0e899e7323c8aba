#include "sinew/inverse/inverse_problem.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

// Regularisation on the change of effort, relative to the best-driven direction. It vanishes at rest, so it does not
// bias the answer; directions that move the effector less than 1e-5 of the best one converge over several cycles.
constexpr double kRegularisation = 1e-10;
constexpr double kRankTolerance = 1e-5;
constexpr double kElasticRegularisation = 1e-9;
constexpr double kRelaxationMargin = 1e-9;

}  // namespace

CycleLimits::CycleLimits(int actuators)
    : displacement_min(actuators), displacement_max(actuators), effort_min(actuators), effort_max(actuators) {}

InverseProblemData::InverseProblemData(int actuators, int max_effector_rows, int max_contacts)
    : unit_compliance(actuators),
      W_aa(actuators, actuators),
      W_ea(max_effector_rows, actuators),
      effector_error(max_effector_rows),
      displacement(actuators),
      effort(actuators),
      W_ca(max_contacts, actuators),
      contact(max_contacts),
      contact_slack(max_contacts) {}

InverseProblemResult::InverseProblemResult(int actuators)
    : effort_change(VecX::Zero(actuators)), effort_violation(VecX::Zero(actuators)) {}

InverseProblem::InverseProblem(int actuators, int max_effector_rows, int max_contacts)
    : actuators_(actuators),
      scale_(actuators),
      W_(actuators, actuators),
      E_(max_effector_rows, actuators),
      C_(max_contacts, actuators),
      contact_min_(max_contacts),
      error_(max_effector_rows),
      energy_(actuators),
      z_min_(actuators),
      z_max_(actuators),
      row_min_(actuators),
      row_max_(actuators),
      z_(actuators),
      relaxation_(actuators),
      row_space_(max_effector_rows, actuators),
      effector_problem_(actuators, actuators + max_contacts + max_effector_rows),
      elastic_problem_(2 * actuators, 3 * actuators + max_contacts),
      energy_problem_(actuators, 2 * actuators + max_contacts),
      effector_solution_(actuators, actuators + max_contacts + max_effector_rows),
      elastic_solution_(2 * actuators, 3 * actuators + max_contacts),
      energy_solution_(actuators, 2 * actuators + max_contacts),
      effector_qp_(actuators, actuators + max_contacts + max_effector_rows),
      elastic_qp_(2 * actuators, 3 * actuators + max_contacts),
      energy_qp_(actuators, 2 * actuators + max_contacts) {}

void InverseProblem::forget() {
  effector_qp_.forget();
  elastic_qp_.forget();
  energy_qp_.forget();
}

void InverseProblem::scale(const InverseProblemData& data, const CycleLimits& limits) {
  const int n = actuators_;
  scale_ = data.unit_compliance.cwiseSqrt();
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i < n; ++i) W_(i, j) = data.W_aa(i, j) / (scale_[i] * scale_[j]);
    for (int i = 0; i < data.effector_rows; ++i) E_(i, j) = data.W_ea(i, j) / scale_[j];
  }
  const double largest = data.effector_rows > 0 ? E_.topRows(data.effector_rows).cwiseAbs().maxCoeff() : 0.0;
  unit_ = largest > 0 ? largest : 1.0;
  E_.topRows(data.effector_rows) /= unit_;
  error_.head(data.effector_rows) = data.effector_error.head(data.effector_rows) / unit_;

  z_min_ = (limits.effort_min - data.effort).cwiseProduct(scale_);
  z_max_ = (limits.effort_max - data.effort).cwiseProduct(scale_);
  row_min_ = (limits.displacement_min - data.displacement).cwiseQuotient(scale_);
  row_max_ = (limits.displacement_max - data.displacement).cwiseQuotient(scale_);
  z_ = data.effort.cwiseProduct(scale_);
  energy_.noalias() = W_ * z_;
  relaxation_.setZero();

  contacts_ = data.contacts;
  for (int i = 0; i < contacts_; ++i) {
    C_.row(i) = data.W_ca.row(i).cwiseQuotient(scale_.transpose());
    const double length = C_.row(i).norm();
    const double factor = length > 0 ? 1 / length : 1.0;
    C_.row(i) *= factor;
    contact_min_[i] = -(data.contact[i] + data.contact_slack[i]) * factor;
  }
}

void InverseProblem::fillRows(int variables, QpProblem& qp) const {
  const int n = actuators_;
  qp.C.topLeftCorner(n + contacts_, variables).rightCols(variables - n).setZero();
  qp.C.topLeftCorner(n, n) = W_;
  qp.row_lower.head(n) = row_min_;
  qp.row_upper.head(n) = row_max_;
  qp.C.block(n, 0, contacts_, n) = C_.topRows(contacts_);
  qp.row_lower.segment(n, contacts_) = contact_min_.head(contacts_);
  qp.row_upper.segment(n, contacts_).setConstant(std::numeric_limits<double>::infinity());
}

// The rows that hold are equalities, or, unless firm, the heaviest part of the objective.
void InverseProblem::fillEffectors(const InverseProblemData& data, QpProblem& qp) {
  const int n = actuators_, held = data.held_rows, rows = n + contacts_;
  const double weight = equalities_ > 0 ? 0 : kHoldWeight * kHoldWeight;
  const auto wishes = E_.middleRows(held, data.effector_rows - held), bound = E_.topRows(held);
  qp.G.topLeftCorner(n, n).noalias() = wishes.transpose() * wishes;
  qp.g.head(n).noalias() = wishes.transpose() * error_.segment(held, wishes.rows());
  qp.G.topLeftCorner(n, n).noalias() += weight * bound.transpose() * bound;
  qp.g.head(n).noalias() += weight * bound.transpose() * error_.head(held);
  qp.C.block(rows, 0, equalities_, n) = E_.topRows(equalities_);
  qp.row_lower.segment(rows, equalities_) = -error_.head(equalities_);
  qp.row_upper.segment(rows, equalities_) = -error_.head(equalities_);
}

QpStatus InverseProblem::solveEffectors(const InverseProblemData& data, InverseProblemResult& result) {
  const int n = actuators_;
  QpProblem& qp = effector_problem_;
  qp.resize(n, n + contacts_ + equalities_);
  fillEffectors(data, qp);
  const auto E = E_.topRows(data.effector_rows);
  const double largest = std::max(data.effector_rows > 0 ? E.colwise().squaredNorm().maxCoeff() : 0.0, 1e-300);
  qp.G.topLeftCorner(n, n).diagonal().array() += largest * (kRegularisation + data.damping);
  qp.lower.head(n) = z_min_ - relaxation_;
  qp.upper.head(n) = z_max_ + relaxation_;
  fillRows(n, qp);
  const QpStatus status = effector_qp_.solve(qp, effector_solution_);
  result.iterations += effector_solution_.iterations;
  if (status != QpStatus::kSolved) return status;
  z_ = effector_solution_.x.head(n);
  if (negligible(data)) z_.setZero();
  return status;
}

// Whether z = 0 is allowed and leaves the error where it is but for `negligible_gain`.
bool InverseProblem::negligible(const InverseProblemData& data) const {
  const auto E = E_.topRows(data.effector_rows);
  const auto error = error_.head(data.effector_rows);
  double squared = 0;
  for (Eigen::Index k = 0; k < error.size(); ++k) squared += std::pow(error[k] + E.row(k).dot(z_), 2);
  if (!(unit_ * (error.norm() - std::sqrt(squared)) < data.negligible_gain)) return false;
  const auto within = [](const auto& min, const auto& max) { return min.maxCoeff() <= 0 && max.minCoeff() >= 0; };
  return within(z_min_ - relaxation_, z_max_ + relaxation_) && within(row_min_, row_max_) &&
         (contacts_ == 0 || contact_min_.head(contacts_).maxCoeff() <= 0) &&
         unit_ * error_.head(equalities_).norm() < data.negligible_gain;
}

// Unknowns (z, t): least 1/2 |t|^2 with z_min - t <= z <= z_max + t and the displacement rows kept.
QpStatus InverseProblem::relaxEfforts(InverseProblemResult& result) {
  const int n = actuators_;
  QpProblem& qp = elastic_problem_;
  const int rows = n + contacts_;
  qp.resize(2 * n, rows + 2 * n);
  qp.G.topLeftCorner(2 * n, 2 * n).setZero();
  qp.G.topLeftCorner(n, n).diagonal().setConstant(kElasticRegularisation);
  qp.G.block(n, n, n, n).diagonal().setOnes();
  qp.g.head(2 * n).setZero();
  qp.lower.head(n).setConstant(-std::numeric_limits<double>::infinity());
  qp.lower.segment(n, n).setZero();
  qp.upper.head(2 * n).setConstant(std::numeric_limits<double>::infinity());
  fillRows(2 * n, qp);
  qp.C.block(rows, 0, 2 * n, 2 * n).setZero();
  qp.C.block(rows, 0, n, n).diagonal().setOnes();
  qp.C.block(rows, n, n, n).diagonal().setOnes();
  qp.row_lower.segment(rows, n) = z_min_;
  qp.row_upper.segment(rows, n).setConstant(std::numeric_limits<double>::infinity());
  qp.C.block(rows + n, 0, n, n).diagonal().setOnes();
  qp.C.block(rows + n, n, n, n).diagonal().setConstant(-1);
  qp.row_lower.segment(rows + n, n).setConstant(-std::numeric_limits<double>::infinity());
  qp.row_upper.segment(rows + n, n) = z_max_;
  const QpStatus status = elastic_qp_.solve(qp, elastic_solution_);
  result.iterations += elastic_solution_.iterations;
  if (status != QpStatus::kSolved) return status;
  relaxation_ = elastic_solution_.x.segment(n, n);
  result.effort_violation = relaxation_.cwiseQuotient(scale_);
  relaxation_.array() += kRelaxationMargin * (1 + relaxation_.maxCoeff());
  return status;
}

// Keeps what the first level reached, E z, and spends the freedom that is left on the energy. Its failure loses
// nothing: z then stays the first level's.
void InverseProblem::solveEnergy(const InverseProblemData& data, InverseProblemResult& result) {
  const int n = actuators_;
  row_space_.update(E_, data.effector_rows, kRankTolerance);
  const int rank = row_space_.rank();
  if (rank == n) return;
  const auto basis = row_space_.basis().topRows(rank);
  const int rows = n + contacts_;
  QpProblem& qp = energy_problem_;
  qp.resize(n, rows + rank);
  qp.G.topLeftCorner(n, n) = W_;
  qp.G.topLeftCorner(n, n).diagonal().array() += data.damping;
  qp.g.head(n) = energy_;
  qp.lower.head(n) = z_min_ - relaxation_;
  qp.upper.head(n) = z_max_ + relaxation_;
  fillRows(n, qp);
  qp.C.block(rows, 0, rank, n) = basis;
  for (int k = 0; k < rank; ++k) qp.row_lower[rows + k] = basis.row(k).dot(z_);
  qp.row_upper.segment(rows, rank) = qp.row_lower.segment(rows, rank);
  const QpStatus status = energy_qp_.solve(qp, energy_solution_);
  result.iterations += energy_solution_.iterations;
  if (status == QpStatus::kSolved) z_ = energy_solution_.x.head(n);
}

QpStatus InverseProblem::solve(const InverseProblemData& data, const CycleLimits& limits,
                               InverseProblemResult& result) {
  result.iterations = 0;
  result.effort_violation.setZero();
  if (!(data.unit_compliance.minCoeff() > 0)) return result.status = QpStatus::kNotFinite;
  scale(data, limits);
  equalities_ = data.firm ? data.held_rows : 0;
  result.status = solveEffectors(data, result);
  if (result.status != QpStatus::kSolved && equalities_ > 0) {
    equalities_ = 0;
    result.status = solveEffectors(data, result);
  }
  result.held = equalities_ == data.held_rows;
  if (result.status == QpStatus::kInfeasible && relaxEfforts(result) == QpStatus::kSolved) {
    result.status = solveEffectors(data, result);
  }
  if (result.status != QpStatus::kSolved) return result.status;
  solveEnergy(data, result);
  result.effort_change = z_.cwiseQuotient(scale_);
  if (!result.effort_change.allFinite()) result.status = QpStatus::kNotFinite;
  return result.status;
}

}  // namespace sinew
