#include "sinew/hardware/simulated_servo_bus.h"

#include <algorithm>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

std::size_t index(int servo) {
  return static_cast<std::size_t>(servo);
}

std::size_t word(const std::uint8_t* p) {
  return static_cast<std::size_t>(p[0] | p[1] << 8);
}

std::vector<std::uint8_t> makeStatus(std::uint8_t id, std::uint8_t error, const std::uint8_t* data, std::size_t size) {
  std::vector<std::uint8_t> parameters{error};
  parameters.insert(parameters.end(), data, data + size);
  std::vector<std::uint8_t> out;
  appendPacket(id, Instruction::kStatus, parameters.data(), parameters.size(), out);
  return out;
}

}  // namespace

SimulatedServoBus::SimulatedServoBus(const std::vector<std::uint8_t>& ids, int baud,
                                     const SimulatedServo::Parameters& parameters)
    : SimulatedServoBus(ids, baud, std::vector<SimulatedServo::Parameters>(ids.size(), parameters)) {}

SimulatedServoBus::SimulatedServoBus(const std::vector<std::uint8_t>& ids, int baud,
                                     const std::vector<SimulatedServo::Parameters>& parameters)
    : SimulatedSerialBus(baud) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] > kMaxServoId || find(ids[i]) != nullptr)
      throw ConfigError("simulated servo id", std::to_string(ids[i]), "each id once, 0 to 252");
    servos_.emplace_back(ids[i], parameters.at(i));
  }
}

SimulatedServo* SimulatedServoBus::find(std::uint8_t id) {
  for (SimulatedServo& s : servos_)
    if (s.id() == id) return &s;
  return nullptr;
}

// --- Mechanics and faults ---

void SimulatedServoBus::setLoadTorque(int servo, double torque) {
  const Lock lock(mutex_);
  servos_.at(index(servo)).setLoadTorque(torque);
}

double SimulatedServoBus::shaftAngle(int servo) const {
  const Lock lock(mutex_);
  return servos_.at(index(servo)).shaftAngle();
}

void SimulatedServoBus::setShaftAngle(int servo, double angle) {
  const Lock lock(mutex_);
  servos_.at(index(servo)).setShaftAngle(angle);
}

double SimulatedServoBus::motorTorque(int servo) const {
  const Lock lock(mutex_);
  return servos_.at(index(servo)).motorTorque();
}

bool SimulatedServoBus::torqueEnabled(int servo) const {
  const Lock lock(mutex_);
  return servos_.at(index(servo)).torqueEnabled();
}

bool SimulatedServoBus::energised(int servo) const {
  const Lock lock(mutex_);
  return servos_.at(index(servo)).energised();
}

void SimulatedServoBus::step(double dt) {
  const Lock lock(mutex_);
  for (SimulatedServo& s : servos_) s.step(dt);
}

void SimulatedServoBus::setFrozen(int servo, bool frozen) {
  const Lock lock(mutex_);
  servos_.at(index(servo)).setFrozen(frozen);
}

void SimulatedServoBus::setTemperature(int servo, double temperature) {
  const Lock lock(mutex_);
  servos_.at(index(servo)).setTemperature(temperature);
}

void SimulatedServoBus::setSupplyVoltage(double voltage) {
  const Lock lock(mutex_);
  for (SimulatedServo& s : servos_) s.setSupplyVoltage(voltage);
}

void SimulatedServoBus::powerCycle(int servo) {
  const Lock lock(mutex_);
  servos_.at(index(servo)).reboot();
}

void SimulatedServoBus::setFastSyncReadSupported(bool supported) {
  const Lock lock(mutex_);
  fast_sync_read_ = supported;
}

SimulatedServo SimulatedServoBus::servo(int servo) const {
  const Lock lock(mutex_);
  return servos_.at(index(servo));
}

// --- The line ---

void SimulatedServoBus::take(const std::uint8_t* data, std::size_t size, Time now) {
  reader_.put(data, size);
  InstructionView packet;
  while (reader_.next(packet)) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
    for (SimulatedServo& s : servos_) {
      s.setMilliseconds(ms);
      s.feedWatchdog();
    }
    handle(packet, answers_.occupy(packet.frame_size, now));
  }
}

void SimulatedServoBus::handle(const InstructionView& packet, Time received) {
  if (packet.instruction == Instruction::kSyncRead) return answerSyncRead(packet, received);
  if (packet.instruction == Instruction::kFastSyncRead) return answerFastSyncRead(packet, received);
  if (packet.instruction == Instruction::kSyncWrite) return applySyncWrite(packet);
  for (SimulatedServo& s : servos_) {
    if ((packet.id != s.id() && packet.id != kBroadcastId) || !s.answers()) continue;
    const std::uint8_t* p = packet.parameters;
    std::vector<std::uint8_t> data;
    ServoError error = ServoError::kNone;
    int answer_level = 2;  // the status return level from which on this instruction is answered
    const std::uint8_t id = s.id();
    switch (packet.instruction) {
      case Instruction::kPing:
        data.resize(3);
        encodeRegister(s.value(servo_register::kModelNumber), 2, data.data());
        encodeRegister(s.value(servo_register::kFirmwareVersion), 1, data.data() + 2);
        answer_level = 0;
        break;
      case Instruction::kRead:
        answer_level = 1;
        data.resize(packet.size == 4 ? word(p + 2) : 0);
        error = packet.size == 4 ? s.read(word(p), data.size(), data.data()) : ServoError::kDataLength;
        if (error != ServoError::kNone) data.clear();
        break;
      case Instruction::kWrite:
        error = packet.size > 2 ? s.write(word(p), p + 2, packet.size - 2) : ServoError::kDataLength;
        break;
      case Instruction::kRegWrite:
        error = packet.size > 2 ? s.regWrite(word(p), p + 2, packet.size - 2) : ServoError::kDataLength;
        break;
      case Instruction::kAction:
        error = s.action();
        break;
      case Instruction::kClear:
        error = s.clear(p, packet.size);
        break;
      case Instruction::kReboot:
        s.reboot();
        break;
      default:
        error = ServoError::kInstruction;
    }
    if (packet.id == kBroadcastId && packet.instruction != Instruction::kPing) continue;
    if (s.value(servo_register::kStatusReturnLevel) < answer_level) continue;
    const Duration delay = duration(s.value(servo_register::kReturnDelay) * kReturnDelayUnit);
    answers_.send(makeStatus(id, s.errorField(error), data.data(), data.size()), received + delay);
  }
}

void SimulatedServoBus::answerSyncRead(const InstructionView& packet, Time received) {
  if (packet.size < 4) return;
  std::vector<std::uint8_t> data(word(packet.parameters + 2));
  for (std::size_t i = 4; i < packet.size; ++i) {
    SimulatedServo* s = find(packet.parameters[i]);
    if (s == nullptr || !s->answers() || s->value(servo_register::kStatusReturnLevel) < 1) continue;
    const ServoError error = s->read(word(packet.parameters), data.size(), data.data());
    const std::size_t size = error == ServoError::kNone ? data.size() : 0;
    const Duration delay = duration(s->value(servo_register::kReturnDelay) * kReturnDelayUnit);
    answers_.send(makeStatus(s->id(), s->errorField(error), data.data(), size),
                  std::max(received, answers_.lineFree()) + delay);
  }
}

// One packet for all: per device its error, id, data and the CRC of everything so far. It ends at a device that is
// silent.
void SimulatedServoBus::answerFastSyncRead(const InstructionView& packet, Time received) {
  if (!fast_sync_read_ || packet.size < 5) return;
  const std::size_t size = word(packet.parameters + 2), devices = packet.size - 4;
  const std::size_t length = 1 + devices * (size + 4);
  std::vector<std::uint8_t> out{0xFF,
                                0xFF,
                                0xFD,
                                0x00,
                                kBroadcastId,
                                static_cast<std::uint8_t>(length),
                                static_cast<std::uint8_t>(length >> 8),
                                static_cast<std::uint8_t>(Instruction::kStatus)};
  std::vector<std::uint8_t> data(size);
  Duration delay{0};
  for (std::size_t i = 4; i < packet.size; ++i) {
    SimulatedServo* s = find(packet.parameters[i]);
    if (s == nullptr || !s->answers() || s->value(servo_register::kStatusReturnLevel) < 1) break;
    const ServoError error = s->read(word(packet.parameters), size, data.data());
    out.push_back(s->errorField(error));
    out.push_back(s->id());
    out.insert(out.end(), data.begin(), data.end());
    const std::uint16_t crc = calcCrc(out.data(), out.size());
    out.push_back(static_cast<std::uint8_t>(crc));
    out.push_back(static_cast<std::uint8_t>(crc >> 8));
    delay += duration(s->value(servo_register::kReturnDelay) * kReturnDelayUnit);
  }
  if (out.size() > 8) answers_.send(std::move(out), received + delay);
}

void SimulatedServoBus::applySyncWrite(const InstructionView& packet) {
  if (packet.size < 4) return;
  const std::size_t address = word(packet.parameters), size = word(packet.parameters + 2);
  for (std::size_t i = 4; i + size < packet.size; i += size + 1) {
    SimulatedServo* s = find(packet.parameters[i]);
    if (s != nullptr && s->answers()) s->write(address, packet.parameters + i + 1, size);
  }
}

}  // namespace sinew
