#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/device_bus.h"
#include "sinew/hardware/dynamixel_packet.h"
#include "sinew/hardware/servo_registers.h"

namespace sinew {

enum class BusStatus {
  kOk,
  kMissing,      ///< no answer within the time, or only damaged ones
  kDeviceError,  ///< the device answered that it did not do it
  kClosed        ///< the line is gone
};

/// One device's part in a read of many.
struct SyncAnswer {
  static constexpr std::size_t kMaxSize = 32;
  BusStatus status = BusStatus::kMissing;
  std::uint8_t error = 0;  ///< error field: ServoError and kAlertBit
  std::array<std::uint8_t, kMaxSize> data{};
};

/// The master of a Dynamixel bus. Every call is one transaction: what is left of earlier ones is flushed, the request
/// goes out, and only answers of the right device and length count, until all are there or their time is over. Calls
/// take no longer than the time on the line plus `reply_timeout`, and allocate nothing once buffers have grown.
class DynamixelBus {
 public:
  /// `reply_timeout`: how long an answer may be late beyond its time on the line (adapter latency, scheduling).
  DynamixelBus(int baud, Duration reply_timeout);

  /// The line to use from now on, which must outlive its use; nullptr for none.
  void attach(ByteStream* line);

  struct Identity {
    std::uint16_t model = 0;
    std::uint8_t firmware = 0;
  };
  BusStatus ping(std::uint8_t id, Identity& identity);
  BusStatus read(std::uint8_t id, ServoRegister r, std::int32_t& value);
  BusStatus write(std::uint8_t id, ServoRegister r, std::int32_t value);
  /// Blocks of at most SyncAnswer::kMaxSize bytes.
  BusStatus readBlock(std::uint8_t id, std::uint16_t address, std::uint8_t size, std::uint8_t* data);
  BusStatus writeBlock(std::uint8_t id, std::uint16_t address, std::uint8_t size, const std::uint8_t* data);
  BusStatus reboot(std::uint8_t id);
  /// Brings the position into one turn again.
  BusStatus clearTurns(std::uint8_t id);
  /// Writes `values[i]` to device `ids[i]`, answered by none.
  BusStatus syncWrite(ServoRegister r, const std::vector<std::uint8_t>& ids, const std::vector<std::int32_t>& values);
  /// Tells whether the data that device `ids[i]` answered to a read of many can be the answer to the request just made.
  using Plausible = std::function<bool(std::size_t i, const std::uint8_t* data)>;
  /// Reads `size` (at most SyncAnswer::kMaxSize) bytes from `address` of every device into `answers`, of the same
  /// length as `ids`: in one joint answer (fast sync read) as long as the devices know how, else in one answer each.
  /// kMissing when any part is.
  BusStatus syncRead(std::uint16_t address, std::uint16_t size, const std::vector<std::uint8_t>& ids,
                     std::vector<SyncAnswer>& answers, const Plausible& plausible = {});

  /// Error field of the last single answer.
  std::uint8_t lastError() const { return last_error_; }
  bool usesFastSyncRead() const { return fast_ && plain_reads_left_ == 0; }
  /// Tries the joint answer first again, or never.
  void setFastSyncRead(bool fast);
  const BusCounters& counters() const { return counters_; }
  const PacketRejects& rejects() const { return reader_.rejects(); }

 private:
  struct Expectation {
    std::size_t packets = 1;
    std::size_t frame = 0;  // bytes of one answer without stuffing
    Time deadline;
  };
  BusStatus request(std::uint8_t id, Instruction instruction, std::size_t answers, std::size_t answer_size);
  BusStatus transact(std::uint8_t id, Instruction instruction, std::size_t answer_size);
  bool flush();
  BusStatus receive(InstructionView& packet);
  void settle(std::size_t received);
  void countDamage(std::size_t lost);
  BusStatus plainSyncRead(std::uint16_t size, const std::vector<std::uint8_t>& ids, std::vector<SyncAnswer>& answers,
                          const Plausible& plausible);
  BusStatus fastSyncRead(std::uint16_t size, const std::vector<std::uint8_t>& ids, std::vector<SyncAnswer>& answers,
                         const Plausible& plausible);
  bool takeJointAnswer(const InstructionView& packet, std::uint16_t size, const std::vector<std::uint8_t>& ids,
                       std::vector<SyncAnswer>& answers, const Plausible& plausible);

  // A joint answer fails as a whole when one device is silent. After so many failures in a row the devices are asked to
  // answer one by one: for a while when they have answered jointly before, else for good.
  static constexpr int kFastTries = 3;
  static constexpr int kPlainReads = 50;
  ByteStream* line_ = nullptr;
  int baud_;
  Duration reply_timeout_;
  PacketReader reader_;
  std::vector<std::uint8_t> parameters_, out_;
  std::array<std::uint8_t, SyncAnswer::kMaxSize> answer_{};
  Expectation expected_;
  std::size_t lost_ = 0;       // packets of the last transaction not accounted for yet
  std::uint64_t skipped_ = 0;  // the reader's count when the transaction began
  std::uint8_t last_error_ = 0;
  bool fast_ = true;
  bool fast_proven_ = false;
  int fast_failures_ = 0;  // in a row
  int plain_reads_left_ = 0;
  BusCounters counters_;
};

}  // namespace sinew
