#pragma once

#include <array>

#include "sinew/hardware/byte_stream.h"
#include "sinew/hardware/can_device.h"
#include "sinew/hardware/canopen_messages.h"

namespace sinew {

/// Reads and writes entries of one node's object dictionary, one transfer at a time, expedited or in segments. It never
/// waits: `update` sends what is due, `take` is shown what comes. A transfer that is not answered in time is begun anew
/// some times; a server that breaks the protocol is told so and given up. Allocates nothing.
class CanopenSdo {
 public:
  static constexpr std::size_t kCapacity = 64;  ///< bytes of the longest object

  enum class Status {
    kIdle,
    kBusy,
    kDone,
    kAborted,  ///< by the server, or by this side because the server broke the protocol; see `abortCode`
    kSilent    ///< no answer, however often it was asked
  };

  /// Waits `timeout` for each answer, and begins each transfer up to `tries` times.
  CanopenSdo(std::uint8_t node, Duration timeout, int tries);

  // Each begins a transfer; one that is still under way is dropped.
  void startUpload(canopen::ObjectAddress object);
  /// 1 to kCapacity bytes.
  void startDownload(canopen::ObjectAddress object, const std::uint8_t* data, std::size_t size);
  /// A number of `size` (1 to 4) bytes.
  void startDownload(canopen::ObjectAddress object, std::uint32_t value, std::size_t size);
  /// Drops what is under way without a word.
  void reset() { status_ = Status::kIdle; }

  /// Sends what is due at `now`.
  void update(Time now, CanSender& out);
  /// A frame of the bus; whether it was an answer of this node's SDO server.
  bool take(const CanFrame& frame);

  Status status() const { return status_; }
  std::uint32_t abortCode() const { return abort_code_; }
  canopen::ObjectAddress object() const { return object_; }
  // What an upload has brought.
  const std::uint8_t* data() const { return data_.data(); }
  std::size_t size() const { return size_; }
  /// Its first four bytes at most, as a number without or with sign; 0 when there are none.
  std::uint32_t value() const;
  std::int32_t signedValue() const;

  std::uint64_t malformed() const { return malformed_; }  ///< answers that are none by CiA 301
  std::uint64_t stale() const { return stale_; }          ///< sound answers to nothing asked just now

 private:
  enum class Phase { kUpload, kUploadSegments, kDownload, kDownloadSegments };

  void start(Phase phase, canopen::ObjectAddress object);
  void restart();
  CanFrame makeRequest() const;
  std::size_t nextSegment() const;
  bool fits(const canopen::SdoReply& reply) const;
  void advance(const canopen::SdoReply& reply);
  void takeUploadStart(const canopen::SdoReply& reply);
  void takeUploadSegment(const canopen::SdoReply& reply);
  void takeDownloadSegment();
  void abort(std::uint32_t code);
  bool isUpload() const { return first_phase_ == Phase::kUpload; }

  std::uint8_t node_;
  Duration timeout_;
  int tries_;
  Status status_ = Status::kIdle;
  Phase first_phase_ = Phase::kUpload, phase_ = Phase::kUpload;
  canopen::ObjectAddress object_;
  std::array<std::uint8_t, kCapacity> data_{};
  std::size_t size_ = 0;    // of the object, where known
  std::size_t offset_ = 0;  // bytes that have gone over
  bool sized_ = false;      // whether the server has announced the size
  bool toggle_ = false;     // of the segment under way
  bool due_ = false;        // whether the request is to be sent now
  bool abort_due_ = false;  // whether the server is to be told `abort_code_`
  std::uint32_t abort_code_ = 0;
  int tries_left_ = 0;
  Time deadline_{};
  std::array<std::uint8_t, 8> last_segment_{};  // accepted last, to know it again when the line doubles it
  bool has_last_segment_ = false;
  std::uint64_t malformed_ = 0, stale_ = 0;
};

}  // namespace sinew
