#include "sinew/hardware/simulated_servo_bus.h"

#include <algorithm>
#include <string>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

using Lock = std::lock_guard<std::mutex>;

constexpr double kBitsPerByte = 10;  // start, 8 data, stop

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
    : baud_(baud) {
  for (std::size_t i = 0; i < ids.size(); ++i) {
    if (ids[i] > kMaxServoId || find(ids[i]) != nullptr)
      throw ConfigError("simulated servo id", std::to_string(ids[i]), "each id once, 0 to 252");
    servos_.emplace_back(ids[i], parameters.at(i));
  }
}

SimulatedServoBus::~SimulatedServoBus() {
  stop();
}

SimulatedServo* SimulatedServoBus::find(std::uint8_t id) {
  for (SimulatedServo& s : servos_)
    if (s.id() == id) return &s;
  return nullptr;
}

Duration SimulatedServoBus::lineTime(std::size_t bytes) const {
  return duration(kBitsPerByte * static_cast<double>(bytes) / baud_);
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

void SimulatedServoBus::setLineFaults(const LineFaults& faults) {
  const Lock lock(mutex_);
  faults_ = faults;
  random_.seed(faults.seed);
}

LineFaultCounts SimulatedServoBus::lineFaultCounts() const {
  const Lock lock(mutex_);
  return counts_;
}

// --- The line ---

void SimulatedServoBus::receive(const std::uint8_t* data, std::size_t size, Time now) {
  const Lock lock(mutex_);
  reader_.put(data, size);
  InstructionView packet;
  while (reader_.next(packet)) {
    const auto ms = std::chrono::duration_cast<std::chrono::milliseconds>(now.time_since_epoch()).count();
    for (SimulatedServo& s : servos_) {
      s.setMilliseconds(ms);
      s.feedWatchdog();
    }
    line_free_ = std::max(line_free_, now) + lineTime(packet.frame_size);
    handle(packet, line_free_);
  }
}

std::size_t SimulatedServoBus::transmit(std::uint8_t* data, std::size_t capacity, Time now) {
  const Lock lock(mutex_);
  std::size_t count = 0;
  while (!answers_.empty() && answers_.front().due <= now && answers_.front().bytes.size() <= capacity - count) {
    const std::vector<std::uint8_t>& bytes = answers_.front().bytes;
    std::copy(bytes.begin(), bytes.end(), data + count);
    count += bytes.size();
    answers_.pop_front();
  }
  return count;
}

Time SimulatedServoBus::nextDue() const {
  const Lock lock(mutex_);
  return answers_.empty() ? Time::max() : answers_.front().due;
}

// A status packet of its own: `ready` is when its device may start to send.
void SimulatedServoBus::send(std::vector<std::uint8_t> bytes, Time ready) {
  Time due = std::max(ready, line_free_) + lineTime(bytes.size());
  line_free_ = due;
  const double u = std::uniform_real_distribution<double>(0, 1)(random_);
  if (u < faults_.corrupt) {
    ++counts_.corrupted;
    std::uniform_int_distribution<std::size_t> bit(0, 8 * bytes.size() - 1);
    const std::size_t first = bit(random_);  // flipped once for sure: the others never fall on it again
    for (std::size_t n = std::uniform_int_distribution<std::size_t>(0, 2)(random_); n > 0; --n) {
      const std::size_t other = bit(random_);
      if (other != first) bytes[other / 8] = static_cast<std::uint8_t>(bytes[other / 8] ^ (1u << other % 8));
    }
    bytes[first / 8] = static_cast<std::uint8_t>(bytes[first / 8] ^ (1u << first % 8));
  } else if (u < faults_.corrupt + faults_.drop) {
    ++counts_.dropped;
    return;
  } else if (u < faults_.corrupt + faults_.drop + faults_.delay) {
    ++counts_.delayed;
    due += duration(faults_.delay_time);
  } else if (u < faults_.corrupt + faults_.drop + faults_.delay + faults_.duplicate) {
    ++counts_.duplicated;
    line_free_ += lineTime(bytes.size());
    queue(bytes, line_free_);
  } else {
    ++counts_.sent;
  }
  queue(std::move(bytes), due);
}

void SimulatedServoBus::queue(std::vector<std::uint8_t> bytes, Time due) {
  const auto later = [](Time t, const Answer& a) { return t < a.due; };
  answers_.insert(std::upper_bound(answers_.begin(), answers_.end(), due, later), Answer{due, std::move(bytes)});
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
    send(makeStatus(id, s.errorField(error), data.data(), data.size()), received + delay);
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
    send(makeStatus(s->id(), s->errorField(error), data.data(), size), std::max(received, line_free_) + delay);
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
  if (out.size() > 8) send(std::move(out), received + delay);
}

void SimulatedServoBus::applySyncWrite(const InstructionView& packet) {
  if (packet.size < 4) return;
  const std::size_t address = word(packet.parameters), size = word(packet.parameters + 2);
  for (std::size_t i = 4; i + size < packet.size; i += size + 1) {
    SimulatedServo* s = find(packet.parameters[i]);
    if (s != nullptr && s->answers()) s->write(address, packet.parameters + i + 1, size);
  }
}

StreamStatus SimulatedServoBus::poll(ByteStream& line, Duration timeout) {
  std::uint8_t data[PacketReader::kMaxFrame];
  const Time now = line.now(), due = nextDue();
  const Duration until_due = due == Time::max() ? timeout : std::max(Duration{0}, Duration(due - now));
  const StreamResult in = line.read(data, sizeof data, std::min(timeout, until_due));
  if (in.status == StreamStatus::kClosed) return in.status;
  if (in.count > 0) receive(data, in.count, line.now());
  const std::size_t out = transmit(data, sizeof data, line.now());
  if (out > 0 && line.write(data, out, duration(0.01)).status == StreamStatus::kClosed) return StreamStatus::kClosed;
  return in.count + out > 0 ? StreamStatus::kOk : StreamStatus::kTimeout;
}

void SimulatedServoBus::start(ByteStream& line) {
  stop();
  line_ = &line;
  running_ = true;
  thread_ = std::thread(&SimulatedServoBus::serve, this);
}

void SimulatedServoBus::stop() {
  running_ = false;
  if (thread_.joinable()) thread_.join();
}

void SimulatedServoBus::serve() {
  const auto kWait = std::chrono::milliseconds(20);
  while (running_)
    if (poll(*line_, kWait) == StreamStatus::kClosed) std::this_thread::sleep_for(kWait);
}

}  // namespace sinew
