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
  return robot.actuatorCount() + robot.effectorRows() + robot.maxContacts();
}

int countEntries(const RobotModel& robot) {
  int entries = 0;
  for (const Cable& cable : robot.cables()) entries += cable.maxEntries();
  for (const PointEffector& effector : robot.effectors()) entries += 4 * effector.rowCount();
  return entries + robot.maxContactEntries();
}

}  // namespace

CondensedRobot::CondensedRobot(std::shared_ptr<const RobotModel> robot)
    : robot_(std::move(robot)),
      body_(robot_->fem(), robot_->description().gravity),
      rows_(robot_->fem(), countRows(*robot_), countEntries(*robot_)),
      actuators_(robot_->actuatorCount()),
      effector_rows_(robot_->effectorRows()),
      half_(robot_->fem().size(), countRows(*robot_) + 1),
      compliance_(countRows(*robot_), countRows(*robot_)),
      effort_(VecX::Zero(actuators_)),
      free_motion_(countRows(*robot_)),
      displacement_(VecX::Zero(actuators_)),
      gap_(robot_->maxContacts()),
      cable_force_(VecX::Zero(robot_->fem().size())),
      contact_force_(VecX::Zero(robot_->fem().size())),
      half_motion_(robot_->fem().size()),
      motion_(VecX::Zero(robot_->fem().size())),
      contact_stiffness_(robot_->maxContacts()),
      negligible_load_(calcNegligibleLoad(robot_->fem())) {}

StepRule CondensedRobot::makeRule(double period) const {
  const RobotDescription& description = robot_->description();
  return {description.control.model == MotionModel::kDynamic, period, description.damping_mass,
          description.damping_stiffness};
}

void CondensedRobot::addActuators(bool with_stiffness) {
  BlockMatrix* matrix = with_stiffness ? &body_.matrix() : nullptr;
  rows_.clear();
  gap_size_ = 0;
  cable_force_.setZero();
  const std::vector<Vec3>& positions = body_.positions();
  for (int i = 0; i < actuators_; ++i) {
    const Cable& cable = robot_->cables()[i];
    displacement_[i] = cable.calcDisplacement(positions);
    cable.addRow(positions, rows_);
    rows_.addTransposed(i, effort_[i], cable_force_);
    if (with_stiffness) cable.addLoadStiffness(positions, effort_[i], *matrix);
  }
  load_norm_ = std::max(negligible_load_, body_.gravityForce().norm() + cable_force_.norm() + contact_force_.norm());
  for (const Cable& cable : robot_->cables()) cable.addTube(positions, &cable_force_, matrix);
  for (const PointEffector& effector : robot_->effectors()) effector.addRows(rows_);
  body_.load() += cable_force_;
  body_.imbalance() += cable_force_ + contact_force_;
  residual_ = body_.imbalance().norm();
}

void CondensedRobot::assembleSystem(Tangent tangent) {
  body_.linearise(rule_, tangent);
  addActuators(true);
  if (tangent == Tangent::kExact) contact_stiffness_.addTo(robot_->fem(), body_.matrix());
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

void CondensedRobot::addContacts(const ContactFinder& finder) {
  const ContactList& contacts = finder.list();
  finder_ = &finder;
  for (int i = 0; i < contacts.size(); ++i) {
    rows_.beginRow();
    const ContactEntry* entries = contacts.entries(i);
    for (int k = 0; k < contacts.row(i).entries; ++k) rows_.add(entries[k].node, entries[k].gradient);
    gap_[gap_size_++] = contacts.row(i).gap;
  }
}

void CondensedRobot::condense(StageTimes& times) {
  const StageTimer timer(times.compliance);
  SparseCholesky& cholesky = body_.cholesky();
  const auto place = [&cholesky](int i) { return cholesky.permuted(i); };
  half_.leftCols(rows() + 1).setZero();
  for (int i = 0; i < rows(); ++i) rows_.scatter(i, place, half_.col(i).data());
  for (int i = 0; i < cholesky.size(); ++i) half_(place(i), rows()) = body_.load()[i];
  cholesky.forwardSolve(half_, rows() + 1);
  const auto Y = half_.leftCols(rows());
  compliance_.topLeftCorner(rows(), rows()).noalias() = Y.transpose() * Y;
  free_motion_.head(rows()).noalias() = Y.transpose() * half_.col(rows());
}

double CondensedRobot::advance(const VecX& effort_change, const Eigen::Ref<const VecX>& contact_force,
                               double max_node_step, StageTimes& times) {
  const StageTimer timer(times.advance);
  half_motion_ = half_.col(rows());
  half_motion_.noalias() += half_.leftCols(actuators_) * effort_change;
  half_motion_.noalias() += half_.middleCols(firstContact(), contacts()) * contact_force;
  contact_force_.setZero();
  for (int i = 0; i < contacts(); ++i) rows_.addTransposed(firstContact() + i, contact_force[i], contact_force_);
  contact_stiffness_.clear();
  if (contacts() > 0) contact_stiffness_.update(*finder_, contact_force, body_.positions());
  body_.cholesky().backwardSolve(half_motion_, motion_);
  return body_.advance(motion_, max_node_step);
}

void CondensedRobot::reset() {
  body_.reset();
  contact_force_.setZero();
  contact_stiffness_.clear();
}

}  // namespace sinew
