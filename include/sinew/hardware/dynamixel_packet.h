#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace sinew {

/// Dynamixel protocol 2.0 framing, after ROBOTIS' e-Manual (emanual.robotis.com/docs/en/dxl/protocol2):
///   FF FF FD 00 | id | length L H | instruction | [error] parameters | CRC L H
/// length = bytes from the instruction to the CRC. Inside instruction .. parameters an FD follows every FF FF FD (byte
/// stuffing); length and CRC hold for the stuffed bytes.

enum class Instruction : std::uint8_t {
  kPing = 0x01,
  kRead = 0x02,
  kWrite = 0x03,
  kRegWrite = 0x04,
  kAction = 0x05,
  kReboot = 0x08,
  kClear = 0x10,
  kStatus = 0x55,
  kSyncRead = 0x82,
  kSyncWrite = 0x83,
  kFastSyncRead = 0x8A
};

constexpr std::uint8_t kBroadcastId = 0xFE;
constexpr std::uint8_t kMaxServoId = 0xFC;

/// Error field of a status packet: bits 0..6 say why the instruction failed, bit 7 that the device has a hardware
/// alert.
enum class ServoError : std::uint8_t {
  kNone = 0,
  kResultFail = 1,
  kInstruction = 2,
  kCrc = 3,
  kDataRange = 4,
  kDataLength = 5,
  kDataLimit = 6,
  kAccess = 7
};
constexpr std::uint8_t kAlertBit = 0x80;

/// CRC-16 with polynomial 0x8005, not reflected, no final xor; `crc` is the value so far (0 at the start).
std::uint16_t calcCrc(const std::uint8_t* data, std::size_t size, std::uint16_t crc = 0);

/// Appends one whole packet of `instruction` to `id` to `out`. The parameters must fit 16 bits of length.
void appendPacket(std::uint8_t id, Instruction instruction, const std::uint8_t* parameters, std::size_t size,
                  std::vector<std::uint8_t>& out);

/// One packet that passed every check. The parameters are unstuffed (those of a status packet start with its error
/// byte), the pointers valid until the reader takes more bytes.
struct InstructionView {
  std::uint8_t id = 0;
  Instruction instruction = Instruction::kPing;
  const std::uint8_t* parameters = nullptr;
  std::size_t size = 0;
  const std::uint8_t* frame = nullptr;  ///< the packet as it came, header to CRC
  std::size_t frame_size = 0;
};

/// Why bytes were thrown away.
struct PacketRejects {
  std::uint64_t noise = 0;     ///< bytes outside of any packet
  std::uint64_t header = 0;    ///< headers with an impossible id or length
  std::uint64_t crc = 0;       ///< whole packets whose CRC did not match
  std::uint64_t stuffing = 0;  ///< whole packets with an FF FF FD that nothing follows
};

/// Finds packets in a stream of bytes. A length is checked before its bytes are waited for, and after any reject only
/// one byte is dropped before the search goes on, so that a true packet behind a false header is not lost. Never
/// allocates after construction.
class PacketReader {
 public:
  static constexpr std::size_t kMaxFrame = 2048;  ///< bytes, header to CRC

  PacketReader();

  /// The longest frame that is believed from now on, in bytes.
  void setMaxFrame(std::size_t size);
  /// Room for new bytes; pass what was filled to `take()`.
  std::uint8_t* space() { return buffer_.data() + end_; }
  std::size_t capacity() const { return buffer_.size() - end_; }
  void take(std::size_t size) { end_ += size; }
  void put(const std::uint8_t* data, std::size_t size);  ///< space() + take(); bytes beyond the capacity count as noise

  /// The next whole packet; false when more bytes are needed.
  bool next(InstructionView& packet);

  /// Bytes that wait for the rest of their packet.
  std::size_t pending() const { return end_ - begin_; }

  /// Throws away what is left; returns how many bytes that were.
  std::size_t clear();

  const PacketRejects& rejects() const { return rejects_; }
  /// Bytes thrown away since construction, for any reason, `clear()` included.
  std::uint64_t skipped() const { return skipped_; }

 private:
  void drop(std::size_t bytes);
  void compact();
  bool unstuff(InstructionView& packet);

  std::vector<std::uint8_t> buffer_;
  std::vector<std::uint8_t> plain_;  // unstuffed parameters of the last packet
  std::size_t begin_ = 0;
  std::size_t end_ = 0;
  std::size_t max_frame_ = kMaxFrame;
  PacketRejects rejects_;
  std::uint64_t skipped_ = 0;
};

}  // namespace sinew
