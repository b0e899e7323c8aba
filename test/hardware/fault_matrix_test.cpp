// Every simulated device, every fault, at rest, moving and under load: how fast the driver and the device itself react,
// that no limit is passed meanwhile, that recovery works and that nothing moves on it.

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "hardware/check_line.h"
#include "hardware/virtual_hardware.h"
#include "sinew/hardware/hardware_driver.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.01;         // s
constexpr int kMissingLimit = 10;        // cycles
constexpr double kCommandTimeout = 0.1;  // s
constexpr double kRelaxTime = 0.3;       // s
constexpr double kWatchdog = 0.1;        // s
constexpr double kWatchTime = 0.2;       // s
constexpr double kStiffness = 400;       // N/m of the robot at each cable
constexpr double kPretension = 1;        // N at displacement 0
const double kUnknown = std::numeric_limits<double>::quiet_NaN();

/// A kind of device, as far as the matrix has to know it.
struct Kind {
  std::string name;
  std::string bus;        // YAML of its bus
  std::string common;     // YAML with what its actuators have in common
  std::string actuators;  // YAML of two
  double nominal, dip;    // V
  double hot;             // degC
  double notice = 0;      // s between the device's own reports of its state
};

const std::string kCable =
    "spool_radius: 0.01, sign: 1, displacement_min: -0.03, displacement_max: 0.06, rate_max: 0.04, tension_max: 20,"
    " on_timeout: relax, homing: {method: present},"
    " watch: {difference_max: 0.008, tension_missing: 4, time: 0.2, temperature_max: .inf, current_max: .inf}";
const std::string kChannel =
    "pressure_min: 0, pressure_max: 60000, rate_max: 100000, pressure_limit: 70000, on_timeout: vent,"
    " watch: {difference_max: 8000, time: 0.2, pressure_max: 75000}";
const std::string kCan = "protocol: can, port: virtual/can, bitrate: 1000000";

const std::vector<Kind> kKinds = {
    {"dynamixel", "protocol: dynamixel2, port: virtual, baud: 1000000",
     "servo: {torque_constant: 1.78, " + kCable + "}", "{name: a, id: 1}, {name: b, id: 2}", 12, 8, 95},
    {"canopen", kCan, "drive: {torque_constant: 0.5, counts_per_turn: 4096, gear: 10, " + kCable + "}",
     "{name: a, id: 1, device: canopen}, {name: b, id: 2, device: canopen}", 24, 12, 120, 0.1},
    {"odrive", kCan, "odrive: {torque_constant: 0.5, gear_ratio: 1, " + kCable + "}",
     "{name: a, id: 1, device: odrive}, {name: b, id: 2, device: odrive}", 24, 9, 120, 0.1},
    {"pressure_serial", "protocol: pressure_board, port: virtual, baud: 1000000",
     "pressure_channel: {" + kChannel + "}", "{name: a, id: 1, channel: 0}, {name: b, id: 1, channel: 1}", 12, 6, 95},
    {"pressure_can", kCan, "pressure_channel: {" + kChannel + "}",
     "{name: a, id: 1, channel: 0, device: pressure_board}, {name: b, id: 1, channel: 1, device: pressure_board}", 12,
     6, 95}};

HardwareDescription describe(const Kind& kind) {
  return HardwareDescription::parse("hardware:\n  bus: {" + kind.bus +
                                        ", simulated: true, reply_timeout: 0.002, missing_limit: 10}\n"
                                        "  rate: 100\n  command_timeout: 0.1\n  hold_limit: 0.5\n  relax_time: 0.3\n"
                                        "  bus_watchdog: 0.1\n  " +
                                        kind.common + "\n  actuators: [" + kind.actuators + "]\n",
                                    kind.name);
}

enum class Condition { kIdle, kMoving, kLoaded };
const char* name(Condition c) {
  constexpr const char* kNames[] = {"idle", "moving", "loaded"};
  return kNames[static_cast<int>(c)];
}

/// One robot of two actuators of a kind, its driver, and a controller that commands what the condition asks for.
class Bench {
 public:
  Bench(const Kind& kind, Condition condition)
      : description_(describe(kind)),
        hardware(description_),
        driver(description_, makeBusGroup(description_, hardware.opener())),
        reader_(description_.names(), description_.quantities()),
        condition_(condition),
        set_point_(2, 0.0) {}

  bool pneumatic() const { return description_.actuators[0].quantity == Quantity::kPressure; }
  double scale() const { return pneumatic() ? 1e6 : 1; }  // Pa for m

  double tension(int i) {
    if (pneumatic() || (snapped && i == 0)) return 0;
    return std::max(0., kPretension + kStiffness * hardware.value(i));
  }

  /// One period: command, bus cycle, mechanics.
  void cycle() {
    const Time begin = hardware.clock.now;
    if (commanding) command();
    driver.update(hardware.clock.now);
    hardware.clock.advanceTo(begin + duration(kPeriod));
    hardware.step(seconds(hardware.clock.now - begin), {tension(0), tension(1)});
    check();
  }

  bool start() {
    for (int n = 0; n < 50; ++n) cycle();  // pumps fill, heartbeats come
    driver.request(DriverRequest::kInit);
    if (!runUntil(DriverState::kReady, 20)) return false;
    if (condition_ == Condition::kIdle) return true;
    for (std::size_t i = 0; i < 2; ++i) set_point_[i] = driver.report().actuators[i].measured;
    base_ = set_point_;
    commanding = true;
    for (int n = 0; n < 150; ++n) cycle();
    return driver.report().state == DriverState::kActive;
  }

  bool runUntil(DriverState state, double most) {
    for (double t = 0; t < most; t += kPeriod) {
      cycle();
      if (driver.report().state == state) return true;
      if (driver.report().state == DriverState::kFault && state == DriverState::kReady) return false;
    }
    return false;
  }

  /// s until `happened`, at most `most`; infinity when it does not.
  double timeUntil(const std::function<bool()>& happened, double most) {
    const Time begin = hardware.clock.now;
    while (seconds(hardware.clock.now - begin) < most) {
      cycle();
      if (happened()) return seconds(hardware.clock.now - begin);
    }
    return std::numeric_limits<double>::infinity();
  }

  bool anyEnergised(bool all_but_first) { return hardware.energised(1) || (!all_but_first && hardware.energised(0)); }

  VirtualHardware& devices() { return hardware; }
  double worstExcess() const { return worst_excess_; }

  HardwareDescription description_;
  VirtualHardware hardware;
  HardwareDriver driver;
  bool commanding = false;
  bool snapped = false;

 private:
  void command() {
    if (condition_ == Condition::kMoving) {
      phase_ += kPeriod;
      for (std::size_t i = 0; i < 2; ++i)
        set_point_[i] = base_[i] + scale() * 0.006 * (1 - std::cos(2 * kPi * phase_ / 1.6));
    } else {
      const double load = pneumatic() ? 30000 : 0.02;  // Pa, or m: 8 N
      for (std::size_t i = 0; i < 2; ++i) set_point_[i] = std::min(base_[i] + load, set_point_[i] + load / 60);
    }
    const std::vector<std::uint8_t> modes(2, pneumatic() ? 2 : 0);
    std::vector<double> expected(2, kUnknown);
    if (!pneumatic())
      for (int i = 0; i < 2; ++i)
        expected[static_cast<std::size_t>(i)] = std::max(0., kPretension + kStiffness * hardware.value(i));
    driver.offer(
        reader_.read(7, ++sequence_, 0, description_.names(), modes, set_point_, expected, hardware.clock.now));
  }

  // What must hold whatever fails: set points within their limits, tension and pressure within the devices'.
  void check() {
    for (std::size_t i = 0; i < 2; ++i) {
      const ActuatorDescription& a = description_.actuators[i];
      const double range = a.max - a.min, applied = driver.report().applied[i];
      double excess = std::max(a.min - applied, applied - a.max) / range - 0.05;
      if (takesCommands(driver.report().state)) {
        EXPECT_TRUE(applied >= a.min && applied <= a.max) << a.name << " is told " << applied;
        // From one cycle to the next, which may follow on one that was late.
        if (last_applied_.size() == 2) {
          EXPECT_LE(std::abs(applied - last_applied_[i]), 2 * a.rate_max * kPeriod * (1 + 1e-9)) << a.name;
        }
      }
      if (pneumatic()) excess = std::max(excess, (hardware.value(static_cast<int>(i)) - 70000) / 70000 - 0.05);
      worst_excess_ = std::max(worst_excess_, excess);
    }
    last_applied_ = takesCommands(driver.report().state) ? driver.report().applied : std::vector<double>();
  }

  CommandReader reader_;
  Condition condition_;
  std::vector<double> set_point_, base_, last_applied_;
  double phase_ = 0, worst_excess_ = -1;
  std::uint32_t sequence_ = 0;
};

/// A fault: how it comes and goes, and what is to follow.
struct Fault {
  std::string name;
  std::function<void(Bench&, const Kind&)> begin, end;
  DriverState leads_to = DriverState::kFault;
  std::function<double(const Kind&)> bound;         // s until the driver is there
  std::function<bool(const Kind&, Condition)> has;  // whether the device can have it
  bool device_reacts = true;                        // whether every actuator must let go in the end
  bool first_is_deaf = false;                       // the first actuator's device cannot act
};

bool always(const Kind&, Condition) {
  return true;
}
bool isPneumatic(const Kind& kind) {
  return kind.name.rfind("pressure", 0) == 0;
}

double twoCycles(const Kind& kind) {
  return 2 * kPeriod + kind.notice + 1e-9;
}
double deviceLoss(const Kind&) {
  return (kMissingLimit + 2) * kPeriod + 1e-9;
}

SimulatedBus& bus(Bench& b) {
  return b.hardware.bus(0);
}

Fault makeLineFault(const std::string& name, double LineFaults::*which, double probability) {
  const auto set = [which](Bench& b, double p) {
    LineFaults faults;
    faults.*which = p;
    faults.delay_time = 0.004;
    bus(b).setLineFaults(faults);
  };
  Fault f;
  f.name = name;
  f.begin = [=](Bench& b, const Kind&) { set(b, probability); };
  f.end = [=](Bench& b, const Kind&) { set(b, 0); };
  f.bound = deviceLoss;
  f.has = always;
  return f;
}

const std::vector<Fault>& faults() {
  static const std::vector<Fault> kFaults = [] {
    std::vector<Fault> list;
    list.push_back(makeLineFault("silence", &LineFaults::drop, 1));
    list.push_back(makeLineFault("corrupt", &LineFaults::corrupt, 1));
    list.push_back(makeLineFault("late", &LineFaults::delay, 1));
    Fault f;
    f.name = "disconnect";
    f.begin = [](Bench& b, const Kind&) { b.hardware.plugged = false; };
    f.end = [](Bench& b, const Kind&) { b.hardware.plugged = true; };
    f.bound = [](const Kind&) { return 2 * kPeriod + 1e-9; };
    f.has = always;
    list.push_back(f);
    f.name = "freeze";  // whoever can do nothing at all cannot let go either
    f.begin = [](Bench& b, const Kind&) { bus(b).setFrozen(0, true); };
    f.end = [](Bench& b, const Kind&) { bus(b).setFrozen(0, false); };
    f.bound = deviceLoss;
    f.first_is_deaf = true;
    list.push_back(f);
    f.first_is_deaf = false;
    f.name = "overheat";
    f.begin = [](Bench& b, const Kind& k) { bus(b).setTemperature(0, k.hot); };
    f.end = [](Bench& b, const Kind&) { bus(b).setTemperature(0, 30); };
    f.bound = twoCycles;
    list.push_back(f);
    f.name = "supply_dip";
    f.begin = [](Bench& b, const Kind& k) { bus(b).setSupplyVoltage(k.dip); };
    f.end = [](Bench& b, const Kind& k) { bus(b).setSupplyVoltage(k.nominal); };
    // An ODrive or a board that is browned out cannot say so.
    f.bound = [](const Kind& k) { return std::max(twoCycles(k), deviceLoss(k)); };
    list.push_back(f);
    f.name = "power_cycle";
    f.begin = [](Bench& b, const Kind&) { bus(b).powerCycle(0); };
    f.end = [](Bench&, const Kind&) {};
    f.bound = twoCycles;
    list.push_back(f);
    f.name = "leak";
    f.begin = [](Bench& b, const Kind&) { bus(b).setLeak(0, 60); };
    f.end = [](Bench& b, const Kind&) { bus(b).setLeak(0, 0); };
    f.bound = [](const Kind&) { return 2 * kPeriod + kWatchTime + 0.2; };
    f.has = [](const Kind& k, Condition c) { return isPneumatic(k) && c == Condition::kLoaded; };
    list.push_back(f);
    f.name = "snap";
    f.begin = [](Bench& b, const Kind&) { b.snapped = true; };
    f.end = [](Bench& b, const Kind&) { b.snapped = false; };
    f.bound = [](const Kind&) { return 2 * kPeriod + kWatchTime + 0.1; };
    f.has = [](const Kind& k, Condition c) { return !isPneumatic(k) && c == Condition::kLoaded; };
    list.push_back(f);
    f.name = "command_loss";
    f.begin = [](Bench& b, const Kind&) { b.commanding = false; };
    f.end = [](Bench&, const Kind&) {};
    f.leads_to = DriverState::kHolding;
    f.bound = [](const Kind&) { return kCommandTimeout + kPeriod + 1e-9; };
    f.has = [](const Kind&, Condition c) { return c != Condition::kIdle; };
    f.device_reacts = false;
    list.push_back(f);
    f.name = "emergency_stop";
    f.begin = [](Bench& b, const Kind&) { b.driver.setEmergencyStop(true); };
    f.end = [](Bench& b, const Kind&) { b.driver.setEmergencyStop(false); };
    f.leads_to = DriverState::kSafe;
    f.bound = [](const Kind&) { return kPeriod + 1e-9; };
    f.has = always;
    f.device_reacts = true;
    list.push_back(f);
    return list;
  }();
  return kFaults;
}

class FaultMatrix : public testing::TestWithParam<int> {};

void runCell(const Kind& kind, const Fault& fault, Condition condition) {
  const std::string cell = kind.name + "." + fault.name + "." + name(condition);
  SCOPED_TRACE(cell);
  Bench b(kind, condition);
  ASSERT_TRUE(b.start()) << b.driver.report().reason;

  fault.begin(b, kind);
  const double reaction = b.timeUntil([&] { return b.driver.report().state == fault.leads_to; }, 3);
  checkAtMost(("fault_matrix.reaction." + cell).c_str(), 1e3 * reaction, 1e3 * fault.bound(kind), "ms");
  const bool whole_board = fault.first_is_deaf && isPneumatic(kind);  // both channels are on it
  if (fault.device_reacts && !whole_board) {
    // The driver lets go over relax_time where it can; where it cannot, the devices' own watchdogs do.
    const double letting_go = b.timeUntil([&] { return !b.anyEnergised(fault.first_is_deaf); }, 3);
    checkAtMost(("fault_matrix.device." + cell).c_str(), 1e3 * letting_go,
                1e3 * (std::max(kRelaxTime, kWatchdog) + 0.15), "ms");
  }
  b.commanding = false;
  EXPECT_FALSE(fault.leads_to == DriverState::kFault && b.driver.report().reason.empty());

  fault.end(b, kind);
  for (int n = 0; n < 300; ++n) b.cycle();  // until nothing drags or vents any more
  const double before[2] = {b.hardware.value(0), b.hardware.value(1)};
  ASSERT_TRUE(b.driver.request(DriverRequest::kRecover)) << b.driver.report().reason;
  EXPECT_TRUE(b.runUntil(DriverState::kReady, 20)) << b.driver.report().reason;
  for (int n = 0; n < 20; ++n) b.cycle();
  EXPECT_EQ(b.driver.report().state, DriverState::kReady) << b.driver.report().reason;
  double moved = 0;
  for (int i = 0; i < 2; ++i) moved = std::max(moved, std::abs(b.hardware.value(i) - before[i]) / b.scale());
  checkAtMost(("fault_matrix.moved." + cell).c_str(), 1e3 * moved, b.pneumatic() ? 0.6 : 0.1, "mm");
  EXPECT_LE(b.worstExcess(), 0) << "a limit was passed";
}

TEST_P(FaultMatrix, ReactsInTimeAndRecoversWithoutMoving) {
  const Kind& kind = kKinds[static_cast<std::size_t>(GetParam())];
  for (const Fault& fault : faults())
    for (const Condition condition : {Condition::kIdle, Condition::kMoving, Condition::kLoaded})
      if (fault.has(kind, condition)) runCell(kind, fault, condition);
}

// What a bad line does to one packet in twenty changes nothing but counters, and neither does one that comes twice.
TEST_P(FaultMatrix, RidesOutABadLine) {
  const Kind& kind = kKinds[static_cast<std::size_t>(GetParam())];
  for (const Condition condition : {Condition::kIdle, Condition::kMoving, Condition::kLoaded}) {
    Bench b(kind, condition);
    ASSERT_TRUE(b.start()) << b.driver.report().reason;
    LineFaults faults;
    faults.corrupt = faults.drop = faults.delay = 0.0125;
    faults.duplicate = 0.5;
    faults.delay_time = 0.004;
    bus(b).setLineFaults(faults);
    const DriverState state = b.driver.report().state;
    const double left = b.timeUntil([&] { return b.driver.report().state != state; }, 10);
    checkAtLeast(("fault_matrix.ride_out." + kind.name + "." + name(condition)).c_str(), std::min(left, 10.0), 10, "s");
    EXPECT_EQ(b.driver.report().state, state) << b.driver.report().reason;
    EXPECT_GT(bus(b).lineFaultCounts().dropped, 0u);
    EXPECT_GT(bus(b).lineFaultCounts().duplicated, 100u);
  }
}

INSTANTIATE_TEST_SUITE_P(Devices, FaultMatrix, testing::Range(0, 5),
                         [](const auto& kind) { return kKinds[static_cast<std::size_t>(kind.param)].name; });

}  // namespace
}  // namespace sinew
