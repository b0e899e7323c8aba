#include "sinew/body/fem_body.h"

#include <algorithm>
#include <cmath>

namespace sinew {

FemBody::FemBody(const FemModel& model, const Vec3& gravity, int max_rows, CholeskyMethod method, int threads)
    : model_(&model),
      data_(model),
      cholesky_(makeSparseCholesky(method, model.factor(), max_rows, threads)),
      positions_(model.rest()),
      start_(model.rest()),
      velocity_(VecX::Zero(model.size())),
      gravity_(gravity),
      gravity_force_(model.size()),
      load_(VecX::Zero(model.size())),
      imbalance_(VecX::Zero(model.size())),
      way_(VecX::Zero(model.size())) {
  setFrameAcceleration(Vec3::Zero());
}

void FemBody::setFrameAcceleration(const Vec3& acceleration) {
  const Vec3 felt = gravity_ - acceleration;
  for (int i = 0; i < model_->freeCount(); ++i) gravity_force_.segment<3>(3 * i) = model_->mass()[i] * felt;
}

void FemBody::beginStep() {
  std::copy(positions_.begin(), positions_.end(), start_.begin());
}

void FemBody::linearise(const StepRule& rule, Tangent tangent) {
  assemble(*model_, positions_, tangent, data_);
  imbalance_ = data_.force + gravity_force_;
  load_ = imbalance_;
  if (!rule.dynamic) return;

  const double h = rule.period;
  const std::vector<int>& nodes = model_->freeNodes();
  for (int i = 0; i < model_->freeCount(); ++i) way_.segment<3>(3 * i) = positions_[nodes[i]] - start_[nodes[i]];
  data_.tangent.addProduct(-rule.damping_stiffness / h, way_, load_);
  data_.tangent.scale(1 + rule.damping_stiffness / h);
  const double inertia = 1 / (h * h) + rule.damping_mass / h;
  for (int i = 0; i < model_->freeCount(); ++i) {
    const double mass = model_->mass()[i];
    load_.segment<3>(3 * i) += mass / h * velocity_.segment<3>(3 * i) - mass * inertia * way_.segment<3>(3 * i);
    data_.tangent.add(model_->pattern().slot(i, i), mass * inertia * Mat3::Identity());
  }
}

void FemBody::updateLoad() {
  assembleForces(*model_, positions_, data_);
  imbalance_ = data_.force + gravity_force_;
  load_ = imbalance_;
}

double FemBody::advance(const VecX& motion, double max_node_step) {
  double longest = 0;
  for (int i = 0; i < model_->freeCount(); ++i) {
    longest = std::max(longest, motion.segment<3>(3 * i).squaredNorm());
  }
  longest = std::sqrt(longest);
  const double scale = longest > max_node_step ? max_node_step / longest : 1.0;
  const std::vector<int>& nodes = model_->freeNodes();
  for (int i = 0; i < model_->freeCount(); ++i) positions_[nodes[i]] += scale * motion.segment<3>(3 * i);
  return scale;
}

void FemBody::endStep(const StepRule& rule) {
  if (!rule.dynamic) {
    velocity_.setZero();
    return;
  }
  const std::vector<int>& nodes = model_->freeNodes();
  for (int i = 0; i < model_->freeCount(); ++i) {
    velocity_.segment<3>(3 * i) = (positions_[nodes[i]] - start_[nodes[i]]) / rule.period;
  }
}

void FemBody::abandonStep() {
  std::copy(start_.begin(), start_.end(), positions_.begin());
}

void FemBody::place(const std::vector<Vec3>& positions) {
  std::copy(positions.begin(), positions.end(), positions_.begin());
  beginStep();
  velocity_.setZero();
}

}  // namespace sinew
