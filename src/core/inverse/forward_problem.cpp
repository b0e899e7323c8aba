#include "sinew/inverse/forward_problem.h"

#include <cmath>
#include <limits>

namespace sinew {
namespace {

// Contacts that depend on each other leave their forces undetermined: a compliance of their own, relative to that of
// the body under them, far below a micrometre for any force that the body bears.
constexpr double kContactCompliance = 1e-9;

}  // namespace

ForwardProblem::ForwardProblem(const VecX& effort_min, int max_contacts)
    : effort_min_(effort_min),
      scale_(effort_min.size() + max_contacts),
      change_(VecX::Zero(effort_min.size() + max_contacts)),
      actuators_(static_cast<int>(effort_min.size())),
      problem_(actuators_ + max_contacts, 0),
      solution_(actuators_ + max_contacts, 0),
      qp_(actuators_ + max_contacts, 0) {}

bool ForwardProblem::scale(const Eigen::Ref<const MatX>& W, int first_contact) {
  for (int i = 0; i < actuators_; ++i) scale_[i] = std::sqrt(W(i, i));
  for (int i = 0; i < contacts_; ++i) {
    const double own = W(first_contact + i, first_contact + i);
    scale_[actuators_ + i] = own > 0 ? std::sqrt(own) : 1.0;  // nothing gives way to a contact of fixed nodes only
  }
  return scale_.head(actuators_).minCoeff() > 0;
}

QpStatus ForwardProblem::solve(const Eigen::Ref<const MatX>& W, int first_contact, const Vector& displacement,
                               const Vector& gap, const VecX& effort, const Actuation& actuation) {
  const int n = actuators_;
  contacts_ = static_cast<int>(gap.size());
  if (!scale(W, first_contact)) return QpStatus::kNotFinite;
  const int size = n + contacts_;
  const auto row = [n, first_contact](int i) { return i < n ? i : first_contact + i - n; };
  problem_.resize(size, 0);
  for (int j = 0; j < size; ++j) {
    for (int i = 0; i < size; ++i) problem_.G(i, j) = W(row(i), row(j)) / (scale_[i] * scale_[j]);
  }
  for (int i = 0; i < n; ++i) {
    const bool held = actuation.mode[i] == Actuation::Mode::kDisplacement;
    const double change = held ? effort_min_[i] - effort[i] : actuation.value[i] - effort[i];
    problem_.lower[i] = change * scale_[i];
    problem_.upper[i] = held ? std::numeric_limits<double>::infinity() : problem_.lower[i];
    problem_.g[i] = (held ? displacement[i] - actuation.value[i] : displacement[i]) / scale_[i];
  }
  for (int i = 0; i < contacts_; ++i) {
    problem_.G(n + i, n + i) += kContactCompliance;
    problem_.lower[n + i] = 0;
    problem_.upper[n + i] = std::numeric_limits<double>::infinity();
    problem_.g[n + i] = gap[i] / scale_[n + i];
  }
  const QpStatus status = qp_.solve(problem_, solution_);
  if (status == QpStatus::kSolved) change_.head(size) = solution_.x.head(size).cwiseQuotient(scale_.head(size));
  return status;
}

}  // namespace sinew
