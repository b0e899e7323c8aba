#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "sinew/hardware/can_frame.h"

namespace sinew {

/// The object dictionary of a simulated CANopen node: numbers and texts with their access rules, answering with the
/// abort codes of CiA 301 (0: done).
class SimulatedObjectDictionary {
 public:
  enum class Mapping : std::uint8_t { kNone, kReceive, kTransmit };

  struct Entry {
    std::uint16_t index;
    std::uint8_t subindex;
    std::uint8_t size;  // bytes: 1, 2 or 4
    bool is_signed;
    bool writable;
    Mapping mapping;
    std::int64_t initial, min, max;
    std::int64_t value;
  };

  /// Asked before a client's value is taken; answers with an abort code.
  using Check = std::function<std::uint32_t(std::uint16_t index, std::uint8_t subindex, std::int64_t value)>;
  /// Told of every value that a client has written.
  using Written = std::function<void(std::uint16_t index, std::uint8_t subindex)>;

  void setHooks(Check check, Written written);
  void add(const Entry& entry) { entries_.push_back(entry); }
  /// A text that can be read, and written with up to `capacity` bytes when that is not 0.
  void addText(std::uint16_t index, const std::string& text, std::size_t capacity);
  /// Brings the entries with indices from `first` to `last` back to their initial values.
  void reset(std::uint16_t first, std::uint16_t last);

  /// The device's own access: the entry has to exist.
  std::int64_t get(std::uint16_t index, std::uint8_t subindex = 0) const;
  void set(std::uint16_t index, std::uint8_t subindex, std::int64_t value);
  const Entry* find(std::uint16_t index, std::uint8_t subindex) const;

  // A client's access.
  std::uint32_t read(std::uint16_t index, std::uint8_t subindex, std::vector<std::uint8_t>& data) const;
  std::uint32_t write(std::uint16_t index, std::uint8_t subindex, const std::vector<std::uint8_t>& data);

 private:
  struct Text {
    std::uint16_t index;
    std::string value;
    std::size_t capacity;
  };
  Entry* find(std::uint16_t index, std::uint8_t subindex);
  std::uint32_t whyMissing(std::uint16_t index) const;

  std::vector<Entry> entries_;
  std::vector<Text> texts_;
  Check check_;
  Written written_;
};

/// The SDO server of a simulated CANopen node: expedited and segmented transfers of one client.
class SimulatedSdoServer {
 public:
  SimulatedSdoServer(std::uint8_t node, SimulatedObjectDictionary& dictionary)
      : node_(node), dictionary_(&dictionary) {}

  /// Takes a request of 8 bytes; true when `reply` is to be sent.
  bool serve(const CanFrame& request, CanFrame& reply);
  /// Forgets a transfer under way.
  void reset() { transfer_ = Transfer::kNone; }

 private:
  enum class Transfer { kNone, kUpload, kDownload };
  void startUpload(CanFrame& reply);
  void startDownload(const CanFrame& request, CanFrame& reply);
  void uploadSegment(const CanFrame& request, CanFrame& reply);
  void downloadSegment(const CanFrame& request, CanFrame& reply);
  void abort(std::uint32_t code, CanFrame& reply);

  std::uint8_t node_;
  SimulatedObjectDictionary* dictionary_;
  Transfer transfer_ = Transfer::kNone;
  std::uint16_t index_ = 0;
  std::uint8_t subindex_ = 0;
  std::vector<std::uint8_t> data_;
  std::size_t offset_ = 0;
  std::size_t announced_ = 0;  // bytes of a download; 0 when the client has not said
  bool toggle_ = false;
};

}  // namespace sinew
