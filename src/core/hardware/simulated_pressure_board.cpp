#include "sinew/hardware/simulated_pressure_board.h"

#include <sinew_board_link.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kMaxStep = 1e-3;                // s between two looks of the firmware at its sensors
constexpr std::int32_t kBrokenSensor = 9999999;  // Pa that an open wire reads as
constexpr double kSupplyTolerance = 0.2;         // of the nominal voltage
constexpr std::uint32_t kSerialNumber = 1000;    // plus the address

}  // namespace

struct SimulatedPressureBoard::Electronics {
  struct Channel {
    SimulatedChamber chamber;
    sinew_path path = SINEW_PATH_EXHAUST;
    double share = 1;
    bool sensor_broken = false;
  };

  Electronics(int board_address, const Parameters& p)
      : parameters(p),
        address(static_cast<std::uint8_t>(board_address)),
        tank(p.tank_pressure),
        voltage(p.nominal_voltage) {
    channels.resize(static_cast<std::size_t>(p.channels));
    for (Channel& c : channels) c.chamber = SimulatedChamber(p.chamber);
    boot();
  }

  static Electronics& of(void* context) { return *static_cast<Electronics*>(context); }

  sinew_hardware makeHardware();
  sinew_board_settings makeSettings() const;
  void boot();
  bool answers() const { return powered && !frozen; }
  void substep(double dt);
  double sourceOf(sinew_path path) const;

  Parameters parameters;
  std::uint8_t address;
  std::vector<Channel> channels;
  double time = 0;          // s
  double tank;              // Pa gauge
  double voltage;           // V
  double temperature = 30;  // degC
  bool pump = false, pump_broken = false;
  bool emergency_stop = false, frozen = false, powered = true;
  sinew_board board{};
  sinew_serial_link serial{};
  sinew_can_link can{};
};

sinew_hardware SimulatedPressureBoard::Electronics::makeHardware() {
  sinew_hardware h{};
  h.context = this;
  h.millis = [](void* context) { return static_cast<std::uint32_t>(std::llround(of(context).time * 1e3)); };
  h.pressure = [](void* context, std::uint8_t channel) {
    const Channel& c = of(context).channels[channel];
    return c.sensor_broken ? kBrokenSensor : static_cast<std::int32_t>(std::lround(c.chamber.pressure()));
  };
  h.source_pressure = [](void* context) { return static_cast<std::int32_t>(std::lround(of(context).tank)); };
  h.supply = [](void* context) { return static_cast<std::uint16_t>(std::lround(1e3 * of(context).voltage)); };
  h.temperature = [](void* context) { return static_cast<std::int16_t>(std::lround(10 * of(context).temperature)); };
  h.emergency_stop = [](void* context) { return of(context).emergency_stop; };
  h.set_valves = [](void* context, std::uint8_t channel, sinew_path path, std::uint8_t duty) {
    Channel& c = of(context).channels[channel];
    c.path = path;
    c.share = duty / 255.;
  };
  h.set_pump = [](void* context, bool on) { of(context).pump = on; };
  return h;
}

sinew_board_settings SimulatedPressureBoard::Electronics::makeSettings() const {
  sinew_board_settings s{};
  s.identity.firmware_major = 1;
  s.identity.channels = static_cast<std::uint8_t>(channels.size());
  s.identity.serial_number = kSerialNumber + address;
  s.identity.range_min = static_cast<std::int32_t>(parameters.range_min);
  s.identity.range_max = static_cast<std::int32_t>(parameters.range_max);
  s.hysteresis = 100;
  s.proportional_band = 2500;
  s.least_duty = 8;
  s.supply_min = static_cast<std::uint16_t>(1e3 * (1 - kSupplyTolerance) * parameters.nominal_voltage);
  s.supply_max = static_cast<std::uint16_t>(1e3 * (1 + kSupplyTolerance) * parameters.nominal_voltage);
  s.temperature_max = 700;
  s.source_low = static_cast<std::int32_t>(0.9 * parameters.tank_pressure);
  s.source_high = static_cast<std::int32_t>(1.05 * parameters.tank_pressure);
  s.source_time = 5000;
  return s;
}

void SimulatedPressureBoard::Electronics::boot() {
  const sinew_board_settings settings = makeSettings();
  const sinew_hardware hardware = makeHardware();
  sinew_board_start(&board, &settings, &hardware);
  sinew_serial_start(&serial, &board, address);
  sinew_can_start(&can, &board, address);
}

double SimulatedPressureBoard::Electronics::sourceOf(sinew_path path) const {
  if (path == SINEW_PATH_FILL) return tank;
  return path == SINEW_PATH_EVACUATE ? parameters.vacuum : 0;
}

void SimulatedPressureBoard::Electronics::substep(double dt) {
  time += dt;
  if (frozen) return;
  if (powered) sinew_board_update(&board);
  for (Channel& c : channels) {
    const double share = c.path == SINEW_PATH_CLOSED ? 0 : c.share;
    const double taken = c.chamber.step(dt, share, sourceOf(c.path));
    if (c.path == SINEW_PATH_FILL) tank -= taken / parameters.tank_volume;
  }
  if (pump && powered && !pump_broken && tank < parameters.pump_pressure)
    tank += parameters.pump_flow / parameters.tank_volume * dt;
}

SimulatedPressureBoard::SimulatedPressureBoard(int address, const Parameters& parameters) {
  if (address < 1 || address > 247) throw ConfigError("simulated pressure board", std::to_string(address), "1 to 247");
  if (parameters.channels < 1 || parameters.channels > static_cast<int>(SINEW_MAX_CHANNELS))
    throw ConfigError("channels of a simulated pressure board", std::to_string(parameters.channels), "1 to 8");
  electronics_ = std::make_unique<Electronics>(address, parameters);
}

SimulatedPressureBoard::~SimulatedPressureBoard() = default;
SimulatedPressureBoard::SimulatedPressureBoard(SimulatedPressureBoard&&) noexcept = default;
SimulatedPressureBoard& SimulatedPressureBoard::operator=(SimulatedPressureBoard&&) noexcept = default;

int SimulatedPressureBoard::address() const {
  return electronics_->address;
}

int SimulatedPressureBoard::size() const {
  return static_cast<int>(electronics_->channels.size());
}

void SimulatedPressureBoard::take(const std::uint8_t* data, std::size_t size,
                                  std::vector<std::vector<std::uint8_t>>& out) {
  if (!electronics_->answers()) return;
  std::uint8_t answer[SINEW_MAX_FRAME];
  for (std::size_t i = 0; i < size; ++i) {
    const std::size_t count = sinew_serial_take(&electronics_->serial, data[i], answer);
    if (count > 0) out.emplace_back(answer, answer + count);
  }
}

void SimulatedPressureBoard::take(const CanFrame& frame, std::vector<CanFrame>& out) {
  if (!electronics_->answers() || !frame.extended || frame.remote) return;
  sinew_can_frame in{};
  in.id = frame.id;
  in.size = frame.size;
  std::copy(frame.data.begin(), frame.data.end(), in.data);
  sinew_can_frame answers[SINEW_MAX_CAN_FRAMES];
  const std::size_t count = sinew_can_take(&electronics_->can, &in, answers);
  for (std::size_t i = 0; i < count; ++i) {
    CanFrame answer;
    answer.id = answers[i].id;
    answer.extended = true;
    answer.size = answers[i].size;
    std::copy(answers[i].data, answers[i].data + 8, answer.data.begin());
    out.push_back(answer);
  }
}

void SimulatedPressureBoard::step(double dt) {
  const int count = std::max(1, static_cast<int>(std::ceil(dt / kMaxStep - 1e-9)));
  for (int i = 0; i < count; ++i) electronics_->substep(dt / count);
}

double SimulatedPressureBoard::pressure(int channel) const {
  return electronics_->channels.at(static_cast<std::size_t>(channel)).chamber.pressure();
}

bool SimulatedPressureBoard::energised(int channel) const {
  return electronics_->powered && electronics_->board.channels[channel].mode != SINEW_VENT;
}

SimulatedChamber& SimulatedPressureBoard::chamber(int channel) {
  return electronics_->channels.at(static_cast<std::size_t>(channel)).chamber;
}

void SimulatedPressureBoard::setFrozen(bool frozen) {
  electronics_->frozen = frozen;
}

void SimulatedPressureBoard::setTemperature(double temperature) {
  electronics_->temperature = temperature;
}

void SimulatedPressureBoard::setSupplyVoltage(double voltage) {
  Electronics& e = *electronics_;
  e.voltage = voltage;
  const bool powered = voltage >= e.parameters.brown_out;
  if (powered && !e.powered) e.boot();
  if (!powered)
    for (Electronics::Channel& c : e.channels) {
      c.path = SINEW_PATH_EXHAUST;
      c.share = 1;
    }
  e.powered = powered;
}

void SimulatedPressureBoard::powerCycle() {
  electronics_->boot();
}

void SimulatedPressureBoard::setLeak(int channel, double rate) {
  chamber(channel).setLeak(rate);
}

void SimulatedPressureBoard::setEmergencyStop(bool pressed) {
  electronics_->emergency_stop = pressed;
}

void SimulatedPressureBoard::setSensorBroken(int channel, bool broken) {
  electronics_->channels.at(static_cast<std::size_t>(channel)).sensor_broken = broken;
}

void SimulatedPressureBoard::setPumpBroken(bool broken) {
  electronics_->pump_broken = broken;
}

}  // namespace sinew
