#include "sinew/hardware/dynamixel_bus.h"

#include <algorithm>

namespace sinew {
namespace {

constexpr std::size_t kStatusOverhead = 11;  // header, id, length, instruction, error, CRC
constexpr std::size_t kJointOverhead = 8;    // header, id, length, instruction
constexpr std::size_t kJointShare = 4;       // error, id, CRC of each device
constexpr double kBitsPerByte = 10;

std::uint8_t low(std::size_t word) {
  return static_cast<std::uint8_t>(word);
}
std::uint8_t high(std::size_t word) {
  return static_cast<std::uint8_t>(word >> 8);
}

}  // namespace

DynamixelBus::DynamixelBus(int baud, Duration reply_timeout) : baud_(baud), reply_timeout_(reply_timeout) {
  parameters_.reserve(PacketReader::kMaxFrame);
  out_.reserve(PacketReader::kMaxFrame);
}

void DynamixelBus::attach(ByteStream* line) {
  line_ = line;
  reader_.clear();
  skipped_ = reader_.skipped();
  lost_ = 0;
}

void DynamixelBus::setFastSyncRead(bool fast) {
  fast_ = fast;
  fast_proven_ = false;
  fast_failures_ = plain_reads_left_ = 0;
}

// Whatever has arrived before a request cannot be its answer.
bool DynamixelBus::flush() {
  InstructionView packet;
  reader_.setMaxFrame(PacketReader::kMaxFrame);
  for (;;) {
    const StreamResult in = line_->read(reader_.space(), reader_.capacity(), Duration{0});
    if (in.status == StreamStatus::kClosed) return false;
    reader_.take(in.count);
    while (reader_.next(packet)) ++counters_.stale;
    if (in.count == 0) break;
  }
  reader_.clear();
  countDamage(lost_);
  lost_ = 0;
  return true;
}

// Bytes thrown away since the last look, as whole packets: they stand for `lost` expected ones or fewer.
void DynamixelBus::countDamage(std::size_t lost) {
  const std::uint64_t skipped = reader_.skipped() - skipped_;
  skipped_ = reader_.skipped();
  const std::uint64_t frame = std::max<std::uint64_t>(expected_.frame, 1);
  const std::uint64_t damaged = skipped == 0 ? 0 : std::max<std::uint64_t>(1, (skipped + frame / 2) / frame);
  counters_.corrupted += damaged;
  counters_.missing += lost > damaged ? lost - damaged : 0;
}

// Sends `parameters_` and opens the books for `answers` answers of `answer_size` parameters each.
BusStatus DynamixelBus::request(std::uint8_t id, Instruction instruction, std::size_t answers,
                                std::size_t answer_size) {
  if (line_ == nullptr || !flush()) return BusStatus::kClosed;
  out_.clear();
  appendPacket(id, instruction, parameters_.data(), parameters_.size(), out_);
  expected_.packets = answers;
  const std::size_t stuffed = answer_size + answer_size / 3 + 1;
  if (answers > 0) {
    expected_.frame = answer_size;
    reader_.setMaxFrame(stuffed);
  }
  const double line_time = kBitsPerByte * static_cast<double>(out_.size() + answers * stuffed) / baud_;
  const StreamResult result = line_->write(out_.data(), out_.size(), duration(line_time) + reply_timeout_);
  if (result.status == StreamStatus::kClosed) return BusStatus::kClosed;
  expected_.deadline = line_->now() + duration(line_time) + reply_timeout_;
  return BusStatus::kOk;
}

// The next sound packet before the deadline.
BusStatus DynamixelBus::receive(InstructionView& packet) {
  while (!reader_.next(packet)) {
    const Duration left = expected_.deadline - line_->now();
    if (left <= Duration{0}) return BusStatus::kMissing;
    const StreamResult in = line_->read(reader_.space(), reader_.capacity(), left);
    if (in.status == StreamStatus::kClosed) return BusStatus::kClosed;
    reader_.take(in.count);
  }
  return BusStatus::kOk;
}

// Closes the books of a transaction; when a part of a packet is there, only the next flush, which sees the rest of it
// or not, can tell a late packet from a damaged one.
void DynamixelBus::settle(std::size_t received) {
  lost_ = expected_.packets - received;
  if (reader_.pending() > 0) return;
  countDamage(lost_);
  lost_ = 0;
}

BusStatus DynamixelBus::transact(std::uint8_t id, Instruction instruction, std::size_t answer_size) {
  BusStatus status = request(id, instruction, 1, kStatusOverhead + answer_size);
  if (status != BusStatus::kOk) return status;
  InstructionView packet;
  for (;;) {
    status = receive(packet);
    if (status != BusStatus::kOk) break;
    const bool ours = packet.instruction == Instruction::kStatus && packet.id == id;
    const bool refusal = packet.size == 1 && (packet.parameters[0] & ~kAlertBit) != 0;
    if (ours && (packet.size == answer_size + 1 || refusal)) break;
    ++counters_.stale;
  }
  settle(status == BusStatus::kOk ? 1 : 0);
  if (status != BusStatus::kOk) return status;
  last_error_ = packet.parameters[0];
  if (last_error_ != 0) ++counters_.device_error;
  if ((last_error_ & ~kAlertBit) != 0) return BusStatus::kDeviceError;
  std::copy(packet.parameters + 1, packet.parameters + packet.size, answer_.begin());
  return BusStatus::kOk;
}

BusStatus DynamixelBus::ping(std::uint8_t id, Identity& identity) {
  parameters_.clear();
  const BusStatus status = transact(id, Instruction::kPing, 3);
  if (status != BusStatus::kOk) return status;
  identity.model = static_cast<std::uint16_t>(answer_[0] | answer_[1] << 8);
  identity.firmware = answer_[2];
  return status;
}

BusStatus DynamixelBus::readBlock(std::uint8_t id, std::uint16_t address, std::uint8_t size, std::uint8_t* data) {
  parameters_.assign({low(address), high(address), size, 0});
  const BusStatus status = transact(id, Instruction::kRead, size);
  if (status == BusStatus::kOk) std::copy(answer_.begin(), answer_.begin() + size, data);
  return status;
}

BusStatus DynamixelBus::writeBlock(std::uint8_t id, std::uint16_t address, std::uint8_t size,
                                   const std::uint8_t* data) {
  parameters_.assign({low(address), high(address)});
  parameters_.insert(parameters_.end(), data, data + size);
  return transact(id, Instruction::kWrite, 0);
}

BusStatus DynamixelBus::read(std::uint8_t id, ServoRegister r, std::int32_t& value) {
  std::uint8_t data[4] = {};
  const BusStatus status = readBlock(id, r.address, r.size, data);
  if (status == BusStatus::kOk) value = decodeRegister(data, r.size);
  return status;
}

BusStatus DynamixelBus::write(std::uint8_t id, ServoRegister r, std::int32_t value) {
  std::uint8_t data[4] = {};
  encodeRegister(value, r.size, data);
  return writeBlock(id, r.address, r.size, data);
}

BusStatus DynamixelBus::reboot(std::uint8_t id) {
  parameters_.clear();
  return transact(id, Instruction::kReboot, 0);
}

BusStatus DynamixelBus::clearTurns(std::uint8_t id) {
  parameters_.assign({0x01, 0x44, 0x58, 0x4C, 0x22});
  return transact(id, Instruction::kClear, 0);
}

BusStatus DynamixelBus::syncWrite(ServoRegister r, const std::vector<std::uint8_t>& ids,
                                  const std::vector<std::int32_t>& values) {
  parameters_.assign({low(r.address), high(r.address), r.size, 0});
  for (std::size_t i = 0; i < ids.size(); ++i) {
    parameters_.resize(parameters_.size() + 1u + r.size);
    std::uint8_t* p = &parameters_[parameters_.size() - r.size - 1u];
    *p = ids[i];
    encodeRegister(values[i], r.size, p + 1);
  }
  return request(kBroadcastId, Instruction::kSyncWrite, 0, 0);
}

BusStatus DynamixelBus::syncRead(std::uint16_t address, std::uint16_t size, const std::vector<std::uint8_t>& ids,
                                 std::vector<SyncAnswer>& answers, const Plausible& plausible) {
  parameters_.assign({low(address), high(address), low(size), high(size)});
  parameters_.insert(parameters_.end(), ids.begin(), ids.end());
  for (SyncAnswer& a : answers) a.status = BusStatus::kMissing;
  if (!usesFastSyncRead()) {
    plain_reads_left_ = std::max(0, plain_reads_left_ - 1);
    return plainSyncRead(size, ids, answers, plausible);
  }
  const BusStatus status = fastSyncRead(size, ids, answers, plausible);
  fast_failures_ = status == BusStatus::kMissing ? fast_failures_ + 1 : 0;
  fast_proven_ = fast_proven_ || status == BusStatus::kOk;
  if (fast_failures_ >= kFastTries) {
    fast_failures_ = 0;
    fast_ = fast_proven_;
    plain_reads_left_ = kPlainReads;
  }
  return status;
}

// Answers are kept by device, in whatever order they come. A line never reorders what one device sent, so of two
// answers of one device the first was late from an earlier transaction.
BusStatus DynamixelBus::plainSyncRead(std::uint16_t size, const std::vector<std::uint8_t>& ids,
                                      std::vector<SyncAnswer>& answers, const Plausible& plausible) {
  BusStatus status = request(kBroadcastId, Instruction::kSyncRead, ids.size(), kStatusOverhead + size);
  if (status != BusStatus::kOk) return status;
  std::size_t received = 0;
  bool refused = false;
  InstructionView packet;
  while (received < ids.size() && (status = receive(packet)) == BusStatus::kOk) {
    const auto id = std::find(ids.begin(), ids.end(), packet.id);
    const auto i = static_cast<std::size_t>(id - ids.begin());
    const bool refusal = packet.size == 1 && (packet.parameters[0] & ~kAlertBit) != 0;
    const bool ours = packet.instruction == Instruction::kStatus && i < ids.size();
    const bool whole = ours && packet.size == size + 1u && (!plausible || plausible(i, packet.parameters + 1));
    if (!ours || !(whole || refusal)) {
      ++counters_.stale;
      continue;
    }
    SyncAnswer& a = answers[i];
    if (a.status == BusStatus::kMissing)
      ++received;
    else
      ++counters_.stale;
    a.error = packet.parameters[0];
    a.status = refusal ? BusStatus::kDeviceError : BusStatus::kOk;
    refused = refused || refusal;
    if (a.error != 0) ++counters_.device_error;
    std::copy(packet.parameters + 1, packet.parameters + packet.size, a.data.begin());
  }
  settle(received);
  if (status == BusStatus::kOk && refused) return BusStatus::kDeviceError;
  return status;
}

BusStatus DynamixelBus::fastSyncRead(std::uint16_t size, const std::vector<std::uint8_t>& ids,
                                     std::vector<SyncAnswer>& answers, const Plausible& plausible) {
  const std::size_t frame = kJointOverhead + ids.size() * (size + kJointShare);
  BusStatus status = request(kBroadcastId, Instruction::kFastSyncRead, 1, frame);
  if (status != BusStatus::kOk) return status;
  reader_.setMaxFrame(frame);  // not stuffed, so its length is known exactly
  InstructionView packet;
  while ((status = receive(packet)) == BusStatus::kOk) {
    if (takeJointAnswer(packet, size, ids, answers, plausible)) break;
    ++counters_.stale;
  }
  settle(status == BusStatus::kOk ? 1 : 0);
  return status;
}

bool DynamixelBus::takeJointAnswer(const InstructionView& packet, std::uint16_t size,
                                   const std::vector<std::uint8_t>& ids, std::vector<SyncAnswer>& answers,
                                   const Plausible& plausible) {
  if (packet.instruction != Instruction::kStatus || packet.id != kBroadcastId) return false;
  const std::size_t share = size + kJointShare;
  if (packet.frame_size != kJointOverhead + ids.size() * share) return false;
  const std::uint8_t* first = packet.frame + kJointOverhead;
  for (std::size_t i = 0; i < ids.size(); ++i)
    if (first[i * share + 1] != ids[i] || (plausible && !plausible(i, first + i * share + 2))) return false;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const std::uint8_t* part = first + i * share;
    answers[i].error = part[0];
    answers[i].status = (part[0] & ~kAlertBit) == 0 ? BusStatus::kOk : BusStatus::kDeviceError;
    if (part[0] != 0) ++counters_.device_error;
    std::copy(part + 2, part + 2 + size, answers[i].data.begin());
  }
  return true;
}

}  // namespace sinew
