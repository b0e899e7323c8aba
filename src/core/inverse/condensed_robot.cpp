#include "sinew/inverse/condensed_robot.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

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

/// N: unbalanced force of nodes that are off by the rounding of their coordinates.
double calcRoundingForce(const FemModel& fem) {
  VecX stiffness = VecX::Zero(fem.nodeCount());  // N/m
  for (const FemModel::Element& element : fem.elements()) {
    const double modulus = element.lame.lambda + 2 * element.lame.mu;
    for (int a = 0; a < 4; ++a) {
      stiffness[element.nodes[a]] += modulus * element.shape.volume * element.shape.gradients.col(a).squaredNorm();
    }
  }
  double squared = 0;
  for (const int node : fem.freeNodes()) squared += std::pow(stiffness[node] * fem.rest()[node].norm(), 2);
  return std::numeric_limits<double>::epsilon() * std::sqrt(squared);
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
      body_(robot_->fem(), robot_->description().gravity, countRows(*robot_), robot_->description().control.cholesky,
            robot_->description().control.threads),
      carrier_(robot_->description().carrier.axis),
      positions_(robot_->fem().rest()),
      rows_(robot_->fem(), countRows(*robot_), countEntries(*robot_)),
      actuators_(robot_->actuatorCount()),
      effector_rows_(robot_->effectorRows()),
      compliance_(countRows(*robot_), countRows(*robot_)),
      carrier_half_(VecX::Zero(countRows(*robot_) + 1)),
      effort_(VecX::Zero(actuators_)),
      free_motion_(countRows(*robot_)),
      displacement_(VecX::Zero(actuators_)),
      gap_(robot_->maxContacts()),
      cable_force_(VecX::Zero(robot_->fem().size())),
      contact_force_(VecX::Zero(robot_->fem().size())),
      row_force_(VecX::Zero(countRows(*robot_))),
      motion_(VecX::Zero(robot_->fem().size())),
      contact_stiffness_(robot_->maxContacts()),
      negligible_load_(calcNegligibleLoad(robot_->fem())),
      rounding_force_(calcRoundingForce(robot_->fem())) {}

StepRule CondensedRobot::makeRule(double period) const {
  const RobotDescription& description = robot_->description();
  return {description.control.model == MotionModel::kDynamic, period, description.damping_mass,
          description.damping_stiffness};
}

void CondensedRobot::calcDisplacement(VecX& displacement) const {
  const std::vector<Cable>& cables = robot_->cables();
  for (std::size_t i = 0; i < cables.size(); ++i) displacement[i] = cables[i].calcDisplacement(body_.positions());
  if (robot_->hasCarrier()) displacement[actuators_ - 1] = carrier_.travel();
}

void CondensedRobot::calcCablePoints(int cable, std::vector<Vec3>& points) const {
  robot_->cables()[cable].calcPoints(body_.positions(), points);
  for (Vec3& point : points) point += offset();
}

void CondensedRobot::beginStep() {
  body_.beginStep();
  carrier_.beginStep();
}

void CondensedRobot::endStep(const StepRule& rule) {
  body_.endStep(rule);
  carrier_.endStep(rule.dynamic ? carrier_.calcSpeed(rule.period) : 0);
  if (robot_->hasCarrier()) body_.setFrameAcceleration(Vec3::Zero());
}

void CondensedRobot::abandonStep() {
  body_.abandonStep();
  carrier_.abandonStep();
  updatePositions();
}

void CondensedRobot::accelerateCarrier(double travel, const StepRule& rule) {
  carrier_.accelerate(travel, rule.period);
  body_.setFrameAcceleration(carrier_.acceleration());
}

void CondensedRobot::place(const CondensedRobot& other) {
  body_.place(other.body_.positions());
  carrier_.place(other.carrier_.travel());
  updatePositions();
}

void CondensedRobot::imitate(const CondensedRobot& other) {
  place(other);
  contact_force_ = other.contact_force_;
  contact_stiffness_ = other.contact_stiffness_;
}

void CondensedRobot::updatePositions() {
  if (!robot_->hasCarrier()) return;
  const Vec3 offset = carrier_.offset();
  const std::vector<Vec3>& carried = body_.positions();
  for (std::size_t i = 0; i < positions_.size(); ++i) positions_[i] = carried[i] + offset;
}

void CondensedRobot::addActuators(bool with_stiffness) {
  BlockMatrix* matrix = with_stiffness ? &body_.matrix() : nullptr;
  rows_.clear();
  gap_size_ = 0;
  cable_force_.setZero();
  calcDisplacement(displacement_);
  const std::vector<Vec3>& positions = body_.positions();
  for (int i = 0; i < static_cast<int>(robot_->cables().size()); ++i) {
    const Cable& cable = robot_->cables()[i];
    cable.addRow(positions, rows_);
    rows_.addTransposed(i, effort_[i], cable_force_);
    if (with_stiffness) cable.addLoadStiffness(positions, effort_[i], *matrix);
  }
  if (robot_->hasCarrier()) rows_.beginRow();  // it deforms nothing
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

void CondensedRobot::shiftGaps(const ContactFinder& finder) {
  for (int i = 0; i < contacts(); ++i) gap_[i] += finder.calcGapShift(i);
}

void CondensedRobot::condense(StageTimes& times) {
  const StageTimer timer(times.compliance);
  body_.cholesky().condense(rows_.blocks(), body_.load(), compliance_.topLeftCorner(rows(), rows()),
                            free_motion_.head(rows()));
  if (robot_->hasCarrier()) condenseCarrier();
}

void CondensedRobot::condenseCarrier() {
  const int own = actuators_ - 1;
  carrier_compliance_ = compliance_.diagonal().head(own).mean();
  carrier_half_.head(own).setZero();  // pull points travel along
  carrier_half_[own] = 1;
  for (int i = actuators_; i < rows(); ++i) carrier_half_[i] = rows_.translation(i).dot(carrier_.direction());
  carrier_half_[rows()] = effort_[own];
  carrier_half_.head(rows() + 1) *= std::sqrt(carrier_compliance_);
  const auto half = carrier_half_.head(rows());
  compliance_.topLeftCorner(rows(), rows()).noalias() += half * half.transpose();
  free_motion_.head(rows()) += carrier_half_[rows()] * half;
}

double CondensedRobot::calcCarrierMotion(const VecX& effort_change, const Eigen::Ref<const VecX>& contact_force) const {
  if (!robot_->hasCarrier()) return 0;
  return std::sqrt(carrier_compliance_) * (carrier_half_[rows()] + carrier_half_.head(actuators_).dot(effort_change) +
                                           carrier_half_.segment(firstContact(), contacts()).dot(contact_force));
}

double CondensedRobot::advance(const VecX& effort_change, const Eigen::Ref<const VecX>& contact_force,
                               double max_node_step, StageTimes& times) {
  const StageTimer timer(times.advance);
  row_force_.head(actuators_) = effort_change;
  row_force_.segment(firstContact(), contacts()) = contact_force;
  contact_force_.setZero();
  for (int i = 0; i < contacts(); ++i) rows_.addTransposed(firstContact() + i, contact_force[i], contact_force_);
  contact_stiffness_.clear();
  if (contacts() > 0) contact_stiffness_.update(*finder_, contact_force, positions());
  body_.cholesky().calcMotion(row_force_, motion_);

  const double travel = calcCarrierMotion(effort_change, contact_force);
  const double carried = robot_->maxContacts() > 0 ? std::abs(travel) : 0;  // alone, the carrier deforms nothing
  const double share = carried > max_node_step / 2 ? max_node_step / 2 / carried : 1.0;
  motion_ *= share;
  const double scale = share * body_.advance(motion_, max_node_step - share * carried);
  carrier_.advance(scale * travel);
  updatePositions();
  return scale;
}

void CondensedRobot::updateEffort(const VecX& effort_change, const Eigen::Ref<const VecX>& contact_force, double scale,
                                  VecX& effort) const {
  effort += scale * effort_change;
  if (!robot_->hasCarrier()) return;
  effort[actuators_ - 1] =
      -carrier_half_.segment(firstContact(), contacts()).dot(contact_force) / std::sqrt(carrier_compliance_);
}

void CondensedRobot::reset() {
  body_.reset();
  carrier_.place(0);
  updatePositions();
  contact_force_.setZero();
  contact_stiffness_.clear();
}

}  // namespace sinew
