#include "sinew/inverse/condensed_robot.h"

#include <Eigen/Geometry>
#include <algorithm>

#include "sinew/constraint/cable.h"
#include "sinew/constraint/point_effector.h"

namespace sinew {
namespace {

constexpr double kNegligibleStrain = 1e-8;

/// N: strains the whole body by so little that it counts as no load, as in a weightless robot at rest.
double calcNegligibleLoad(const FemModel& fem) {
  double modulus = 0;
  for (const FemModel::Element& element : fem.elements()) modulus = std::max(modulus, element.lame.mu);
  Eigen::AlignedBox3d box;
  for (const Vec3& node : fem.rest()) box.extend(node);
  return kNegligibleStrain * modulus * box.diagonal().squaredNorm();
}

int countRows(const RobotModel& robot) {
  int rows = robot.actuatorCount();
  for (const PointEffector& effector : robot.effectors()) rows += effector.rowCount();
  return rows;
}

int countEntries(const RobotModel& robot) {
  int entries = 0;
  for (const Cable& cable : robot.cables()) entries += cable.maxEntries();
  for (const PointEffector& effector : robot.effectors()) entries += 4 * effector.rowCount();
  return entries;
}

}  // namespace

CondensedRobot::CondensedRobot(std::shared_ptr<const RobotModel> robot)
    : robot_(std::move(robot)),
      body_(robot_->fem(), robot_->description().gravity),
      rows_(robot_->fem(), countRows(*robot_), countEntries(*robot_)),
      actuators_(robot_->actuatorCount()),
      half_(robot_->fem().size(), countRows(*robot_) + 1),
      compliance_(countRows(*robot_), countRows(*robot_)),
      effort_(VecX::Zero(actuators_)),
      free_motion_(countRows(*robot_)),
      displacement_(VecX::Zero(actuators_)),
      cable_force_(VecX::Zero(robot_->fem().size())),
      half_motion_(robot_->fem().size()),
      motion_(VecX::Zero(robot_->fem().size())),
      negligible_load_(calcNegligibleLoad(robot_->fem())) {}

StepRule CondensedRobot::makeRule(double period) const {
  const RobotDescription& description = robot_->description();
  return {description.control.model == MotionModel::kDynamic, period, description.damping_mass,
          description.damping_stiffness};
}

void CondensedRobot::addActuators(bool with_stiffness) {
  BlockMatrix* matrix = with_stiffness ? &body_.matrix() : nullptr;
  rows_.clear();
  cable_force_.setZero();
  const std::vector<Vec3>& positions = body_.positions();
  for (int i = 0; i < actuators_; ++i) {
    const Cable& cable = robot_->cables()[i];
    displacement_[i] = cable.calcDisplacement(positions);
    cable.addRow(positions, rows_);
    rows_.addTransposed(i, effort_[i], cable_force_);
    if (with_stiffness) cable.addLoadStiffness(positions, effort_[i], *matrix);
  }
  load_norm_ = std::max(negligible_load_, body_.gravityForce().norm() + cable_force_.norm());
  for (const Cable& cable : robot_->cables()) cable.addTube(positions, &cable_force_, matrix);
  for (const PointEffector& effector : robot_->effectors()) effector.addRows(rows_);
  body_.load() += cable_force_;
  body_.imbalance() += cable_force_;
  residual_ = body_.imbalance().norm();
}

void CondensedRobot::assembleSystem(Tangent tangent) {
  body_.linearise(rule_, tangent);
  addActuators(true);
}

void CondensedRobot::linearise(const VecX& effort, const StepRule& rule, StageTimes& times) {
  const StageTimer timer(times.assembly);
  effort_ = effort;
  rule_ = rule;
  assembleSystem(Tangent::kExact);
}

void CondensedRobot::relinearise(const VecX& effort, StageTimes& times) {
  const StageTimer timer(times.assembly);
  effort_ = effort;
  body_.updateLoad();
  addActuators(false);
}

bool CondensedRobot::factorise(StageTimes& times) {
  {
    const StageTimer timer(times.factor);
    if (body_.factorise()) return true;
  }
  {
    const StageTimer timer(times.assembly);
    assembleSystem(Tangent::kSemidefinite);
  }
  const StageTimer timer(times.factor);
  return body_.factorise();
}

bool CondensedRobot::condense(StageTimes& times) {
  if (!factorise(times)) return false;
  recondense(times);
  return true;
}

void CondensedRobot::recondense(StageTimes& times) {
  const StageTimer timer(times.compliance);
  SparseCholesky& cholesky = body_.cholesky();
  const auto place = [&cholesky](int i) { return cholesky.permuted(i); };
  half_.setZero();
  for (int i = 0; i < rows(); ++i) rows_.scatter(i, place, half_.col(i).data());
  for (int i = 0; i < cholesky.size(); ++i) half_(place(i), rows()) = body_.load()[i];
  cholesky.forwardSolve(half_, rows() + 1);
  const auto Y = half_.leftCols(rows());
  compliance_.noalias() = Y.transpose() * Y;
  free_motion_.noalias() = Y.transpose() * half_.col(rows());
}

double CondensedRobot::advance(const VecX& effort_change, double max_node_step, StageTimes& times) {
  const StageTimer timer(times.advance);
  half_motion_ = half_.col(rows());
  half_motion_.noalias() += half_.leftCols(actuators_) * effort_change;
  body_.cholesky().backwardSolve(half_motion_, motion_);
  return body_.advance(motion_, max_node_step);
}

void CondensedRobot::reset() {
  body_.reset();
}

}  // namespace sinew
