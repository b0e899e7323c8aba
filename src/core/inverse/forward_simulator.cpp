#include "sinew/inverse/forward_simulator.h"

#include "sinew/constraint/point_effector.h"

namespace sinew {

namespace {

constexpr double kReusableResidual = 0.05;  // of the load; farther from rest an older factor may lead in circles

}  // namespace

struct ForwardSimulator::Impl {
  CondensedRobot condensed;
  ContactFinder finder;
  ForwardStep forward;
  VecX effort, displacement, effectors;
  StageTimes times;
  int steps_per_factor;
  int steps_since_factor = 0;

  Impl(std::shared_ptr<const RobotModel> robot, int steps)
      : condensed(robot),
        finder(*robot),
        forward(*robot),
        effort(VecX::Zero(robot->actuatorCount())),
        displacement(VecX::Zero(robot->actuatorCount())),
        effectors(3 * robot->effectorCount()),
        steps_per_factor(steps) {
    measure();
  }

  ContactFinder* contacts() { return finder.activeOrNull(); }

  void measure() {
    const RobotModel& robot = condensed.robot();
    const std::vector<Vec3>& positions = condensed.positions();
    condensed.calcDisplacement(displacement);
    for (int e = 0; e < robot.effectorCount(); ++e) {
      effectors.segment<3>(3 * e) = robot.effectors()[e].calcPosition(positions);
    }
  }
};

ForwardSimulator::ForwardSimulator(std::shared_ptr<const RobotModel> robot, int steps_per_factor)
    : impl_(std::make_unique<Impl>(std::move(robot), steps_per_factor)) {}

ForwardSimulator::~ForwardSimulator() = default;

Actuation ForwardSimulator::makeActuation() const {
  const int actuators = impl_->condensed.actuators();
  return {std::vector<Actuation::Mode>(static_cast<std::size_t>(actuators), Actuation::Mode::kDisplacement),
          VecX::Zero(actuators)};
}

ForwardStatus ForwardSimulator::step(const Actuation& actuation, double period) {
  const StepRule rule = impl_->condensed.makeRule(period);
  Impl& impl = *impl_;
  const bool again = !rule.dynamic && impl.steps_since_factor > 0 && impl.steps_since_factor < impl.steps_per_factor &&
                     residualRelative() < kReusableResidual;
  const ForwardStatus status =
      again ? impl.forward.stepAgain(actuation, impl.contacts(), impl.condensed, impl.effort, impl.times)
            : impl.forward.step(actuation, rule, impl.contacts(), impl.condensed, impl.effort, impl.times);
  impl.steps_since_factor = status != ForwardStatus::kSolved ? 0 : again ? impl.steps_since_factor + 1 : 1;
  impl_->measure();
  return status;
}

ForwardStatus ForwardSimulator::settle(const Actuation& actuation, double tolerance, int max_steps) {
  const ForwardStatus status = impl_->forward.settle(actuation, tolerance, max_steps, impl_->contacts(),
                                                     impl_->condensed, impl_->effort, impl_->times);
  impl_->steps_since_factor = 0;
  impl_->measure();
  return status;
}

void ForwardSimulator::reset() {
  impl_->steps_since_factor = 0;
  impl_->condensed.reset();
  impl_->effort.setZero();
  impl_->measure();
}

void ForwardSimulator::setObstacles(const std::vector<ObstacleState>& obstacles) {
  impl_->finder.setObstacles(obstacles);
}

const ContactList& ForwardSimulator::contacts() const {
  return impl_->finder.list();
}

Eigen::VectorBlock<const VecX> ForwardSimulator::contactForce() const {
  return impl_->forward.contactForce();
}

const std::vector<Vec3>& ForwardSimulator::nodes() const {
  return impl_->condensed.positions();
}

void ForwardSimulator::calcCablePoints(int cable, std::vector<Vec3>& points) const {
  impl_->condensed.calcCablePoints(cable, points);
}

const VecX& ForwardSimulator::displacement() const {
  return impl_->displacement;
}

const VecX& ForwardSimulator::effort() const {
  return impl_->effort;
}

const VecX& ForwardSimulator::effectors() const {
  return impl_->effectors;
}

double ForwardSimulator::residual() const {
  return impl_->condensed.residual();
}

double ForwardSimulator::residualRelative() const {
  const double load = impl_->condensed.loadNorm();
  return load > 0 ? residual() / load : residual();
}

}  // namespace sinew
