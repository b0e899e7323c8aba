#include <algorithm>
#include <cmath>
#include <cstdio>
#include <variant>

#include "bus_session.h"
#include "bus_text.h"
#include "bus_verbs.h"

namespace sinew {
namespace {

constexpr double kGentleSpeed = 0.005;       // m/s
constexpr double kGentlePressureRate = 5e3;  // Pa/s
constexpr double kPatience = 5;              // s for the measurement to follow
constexpr double kPrintPeriod = 0.5;         // s
constexpr double kArrivedShare = 0.1;        // of the distance that may be left

int findActuator(const HardwareDescription& hardware, const std::string& wanted) {
  std::string list;
  for (std::size_t i = 0; i < hardware.actuators.size(); ++i) {
    if (hardware.actuators[i].name == wanted) return static_cast<int>(i);
    list += (list.empty() ? "" : ", ") + hardware.actuators[i].name;
  }
  throw WrongUse("the file has no actuator '" + wanted + "', expected one of " + list);
}

void limitTension(ActuatorDescription& actuator, const std::string& text) {
  const double tension = parseForce(text, "--tension");
  if (actuator.quantity == Quantity::kPressure) throw WrongUse("--tension is for cables; a pressure has --pressure");
  if (!(tension > 0 && tension <= actuator.cable.tension_max))
    throw WrongUse("--tension must be above 0 and at most the file's tension_max, " +
                   formatEffort(actuator.cable.tension_max, Quantity::kDisplacement));
  actuator.cable.tension_max = tension;
}

void limitPressure(ActuatorDescription& actuator, const std::string& text) {
  if (actuator.quantity != Quantity::kPressure) throw WrongUse("--pressure is for pressures; a cable has --tension");
  const double pressure = parseDistance(text, Quantity::kPressure, "--pressure");
  if (!(pressure > actuator.min && pressure <= actuator.max))
    throw WrongUse("--pressure must be above the file's pressure_min and at most its pressure_max, " +
                   formatDistance(actuator.max, Quantity::kPressure));
  actuator.max = pressure;
  std::get<PressureBoardSettings>(actuator.settings).pressure_limit = pressure;
}

double chooseSpeed(const ActuatorDescription& actuator, const std::string& text) {
  const double gentle = actuator.quantity == Quantity::kPressure ? kGentlePressureRate : kGentleSpeed;
  const double speed =
      text.empty() ? std::min(gentle, actuator.rate_max) : parseSpeed(text, actuator.quantity, "--speed");
  if (!(speed > 0 && speed <= actuator.rate_max))
    throw WrongUse("--speed must be above 0 and at most the file's rate_max, " +
                   formatDistance(actuator.rate_max, actuator.quantity) + "/s");
  return speed;
}

/// One actuator on its way there and back.
class Jog {
 public:
  Jog(BusSession& session, double speed)
      : session_(session),
        actuator_(session.hardware().actuators.front()),
        speed_(speed),
        set_point_(session.report().applied.front()) {}

  double measured() const { return reading().measured; }
  double greatestEffort() const { return greatest_effort_; }

  /// False when it stopped underway. `allowed`: what measured and wanted may differ in the end [m or Pa].
  bool moveTo(double target, double allowed) {
    const Time begin = Clock::now();
    const double travel = std::abs(target - set_point_) / speed_;
    while (set_point_ != target || std::abs(measured() - target) > allowed) {
      if (seconds(Clock::now() - begin) > travel + kPatience) return true;
      if (!step(target)) return false;
    }
    print();
    return true;
  }

 private:
  const ActuatorReading& reading() const { return session_.report().actuators.front(); }

  bool step(double target) {
    const double most = speed_ * session_.period();
    set_point_ += std::max(-most, std::min(most, target - set_point_));
    session_.command({set_point_});
    session_.cycle();
    greatest_effort_ = std::max(greatest_effort_, reading().effort);
    if (Clock::now() >= next_print_) print();
    return session_.report().state == DriverState::kActive && !isStopAsked();
  }

  void print() {
    next_print_ = Clock::now() + duration(kPrintPeriod);
    std::printf("  set point %10s, measured %10s, effort %8s\n", formatDistance(set_point_, actuator_.quantity).c_str(),
                formatDistance(measured(), actuator_.quantity).c_str(),
                formatEffort(reading().effort, actuator_.quantity).c_str());
    std::fflush(stdout);
  }

  BusSession& session_;
  const ActuatorDescription& actuator_;
  double speed_;
  double set_point_;
  double greatest_effort_ = 0;
  Time next_print_{};
};

void requireReach(const ActuatorDescription& actuator, double target) {
  if (target >= actuator.min && target <= actuator.max) return;
  throw WrongUse("that leads to " + formatDistance(target, actuator.quantity) + ", and only " +
                 formatDistance(actuator.min, actuator.quantity) + " to " +
                 formatDistance(actuator.max, actuator.quantity) + " are allowed");
}

int run(BusSession& session, double distance, double speed) {
  const ActuatorDescription& actuator = session.hardware().actuators.front();
  const double start = session.report().applied.front();
  const double target = start + distance;
  requireReach(actuator, target);
  const double allowed = std::max(kArrivedShare * std::abs(distance), actuator.seedTolerance());
  Jog jog(session, speed);
  bool whole = jog.moveTo(target, allowed);
  const double reached = jog.measured();
  whole = whole && jog.moveTo(start, allowed);
  if (!whole) {
    std::printf("ended at %s: %s\n", formatDistance(jog.measured(), actuator.quantity).c_str(),
                session.whyNot().c_str());
    return kNotWell;
  }
  std::printf("%s moved by %s of %s, with at most %s, and is back at %s\n", actuator.name.c_str(),
              formatDistance(reached - start, actuator.quantity).c_str(),
              formatDistance(distance, actuator.quantity).c_str(),
              formatEffort(jog.greatestEffort(), actuator.quantity).c_str(),
              formatDistance(jog.measured(), actuator.quantity).c_str());
  const bool arrived = std::abs(reached - target) <= allowed && std::abs(jog.measured() - start) <= allowed;
  if (!arrived) std::printf("it did not get where it was told: is it stuck, is its limit of effort too low?\n");
  return arrived ? kDone : kNotWell;
}

}  // namespace

int jog(const HardwareDescription& robot, const JogOrder& order) {
  HardwareDescription hardware = select(robot, {findActuator(robot, order.actuator)});
  homeWhereFound(hardware);
  ActuatorDescription& actuator = hardware.actuators.front();
  const double distance = parseDistance(order.distance, actuator.quantity, "DISTANCE");
  const double speed = chooseSpeed(actuator, order.speed);
  if (!order.tension.empty()) limitTension(actuator, order.tension);
  if (!order.pressure.empty()) limitPressure(actuator, order.pressure);
  if (actuator.quantity == Quantity::kDisplacement) requireReach(actuator, distance);  // it is found at 0
  const std::string deed = actuator.name + " goes by " + formatDistance(distance, actuator.quantity) + " at " +
                           formatDistance(speed, actuator.quantity) +
                           "/s and back, and is let go. Every other actuator stays off.";
  if (!isAllowed(deed, order.yes)) return kDone;
  BusSession session(hardware);
  if (!session.setUp()) {
    std::printf("%s\n", session.whyNot().c_str());
    return kNotWell;
  }
  return run(session, distance, speed);
}

}  // namespace sinew
