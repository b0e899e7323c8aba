#include "enabling.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

#include "real_time.h"

namespace sinew {
namespace {

constexpr double kFirstCommandTolerance = 1e-4;  // m between the measured displacement and the first command

std::uint32_t drawSession() {
  std::random_device device;
  return std::uniform_int_distribution<std::uint32_t>(1)(device);
}

std::string inMillimetres(double length) {
  std::ostringstream stream;
  stream << 1e3 * length << " mm";
  return stream.str();
}

}  // namespace

Enabling::Enabling(const ControlSettings& settings, std::shared_ptr<const RobotModel> robot,
                   const ActuatorInbox& actuators, TargetInbox& targets, ControlMode& mode, ControlSession& session)
    : settings_(settings),
      robot_(std::move(robot)),
      actuators_(actuators),
      targets_(targets),
      mode_(mode),
      session_(session) {}

void Enabling::disable() {
  mode_.park();
  mode_.release(Mode::kFollowing, "disabled by request");
}

void Enabling::reset() {
  mode_.park();
  session_.controller.reset();
  session_.followed.setZero();
  targets_.forget();
  mode_.release(Mode::kFollowing, "reset by request");
}

std::string Enabling::enable() {
  if (mode_.enabled()) return "";
  const DriverReading reading = actuators_.latest();
  const bool with_driver = settings_.require_driver || isFresh(reading, steadyNow(), settings_.driver_timeout);
  if (with_driver) {
    const std::string reason = findReasonNotTo(reading);
    if (!reason.empty()) return reason;
  }
  mode_.park();
  targets_.forget();
  session_.with_driver = with_driver;
  const VecX start = with_driver ? reading.measured : session_.followed;
  const std::string failure = resynchronise(start);
  if (!failure.empty()) {
    mode_.release(Mode::kFollowing, "enabling was refused");
    return failure;
  }
  beginSession(start);
  mode_.release(Mode::kControlling, "");
  return "";
}

void Enabling::beginSession(const VecX& start) {
  session_.applied.reset(start);
  session_.session = drawSession();
  session_.sequence = 0;
  session_.enabled_since = steadyNow();
}

std::string Enabling::findReasonNotTo(const DriverReading& reading) const {
  if (!isFresh(reading, steadyNow(), settings_.driver_timeout)) {
    return reading.receipt < 0 ? "no message on " + actuators_.topic() + " yet: is the driver running?"
                               : "the last message on " + actuators_.topic() + " is older than driver_timeout";
  }
  if (!takesCommands(reading.driver_state)) {
    return std::string("the driver is ") + nameOfDriverState(reading.driver_state) +
           ", it has to be READY, ACTIVE or HOLDING: " + actuators_.driverReason();
  }
  if (!reading.all_measured) return "the driver could not read every actuator";
  if (!reading.all_zeroed) return "an actuator does not know its zero: home it first";
  if (reading.session != 0) return "the driver obeys another session: call its recover service first";
  return "";
}

// Moves the parked model to the measurement and tries the first command, with every effector free, on the spot: what
// would move the robot on enabling is found out before anything is sent.
std::string Enabling::resynchronise(const VecX& measured) {
  CycleInput& input = session_.input;
  CycleOutput& output = session_.output;
  std::fill(input.targeted.begin(), input.targeted.end(), false);
  input.applied = session_.followed;
  session_.controller.step(input, output);  // so that it knows where the obstacles are
  const double difference = session_.controller.resynchronise(measured);
  if (!std::isfinite(difference)) return "the model finds no equilibrium at the measured displacements";
  if (difference > kFirstCommandTolerance) {
    return "the model comes no nearer to the measured displacements than " + inMillimetres(difference);
  }
  input.applied = measured;
  if (session_.controller.step(input, output) == CycleStatus::kHeld) return describe(output);
  session_.followed = measured;
  session_.last_command = output.displacement;
  return compareFirstCommand(session_.with_driver ? actuators_.latest().measured : measured);
}

std::string Enabling::compareFirstCommand(const VecX& measured) const {
  for (int i = 0; i < measured.size(); ++i) {
    const double difference = std::abs(session_.last_command[i] - measured[i]);
    if (difference <= kFirstCommandTolerance) continue;
    return "the first command for " + robot_->actuators()[static_cast<std::size_t>(i)].name + " would be " +
           inMillimetres(difference) + " from its measurement, more than " + inMillimetres(kFirstCommandTolerance);
  }
  return "";
}

}  // namespace sinew
