#include "bus_scan.h"

#include <algorithm>
#include <cstdio>
#include <tuple>

#include "sinew/hardware/can_scan.h"
#include "sinew/hardware/canopen_messages.h"
#include "sinew/hardware/cobs.h"
#include "sinew/hardware/dynamixel_bus.h"
#include "sinew/hardware/pressure_message.h"
#include "sinew/hardware/servo_models.h"

namespace sinew {
namespace {

constexpr double kBitsPerByte = 10;
constexpr double kTurnaround = 0.002;  // s within which a pressure board begins to answer
constexpr int kHelloRounds = 2;
constexpr double kAnswerTime = 0.02;     // s that a CAN node is given
constexpr double kSendTime = 0.02;       // s for a frame to find room
constexpr double kListeningSlice = 0.1;  // s between two looks at the progress
constexpr int kOdriveBits = 5;           // of an ODrive's identifier, below its node
constexpr canopen::ObjectAddress kVendor{0x1018, 1}, kProduct{0x1018, 2};

template <typename... Values>
std::string format(const char* text, Values... values) {
  char out[200];
  std::snprintf(out, sizeof out, text, values...);
  return out;
}

std::string describeServo(const DynamixelBus::Identity& identity) {
  const ServoModel* model = findServoModel(identity.model);
  return format("%s (model %d), firmware %d", model != nullptr ? model->name : "a model that Sinew cannot drive",
                identity.model, identity.firmware);
}

std::string describeBoard(const PressureIdentity& board) {
  return format("%d channels, %.0f to %.0f kPa, firmware %d.%d, serial number %u", board.channels,
                1e-3 * board.range_min, 1e-3 * board.range_max, board.firmware_major, board.firmware_minor,
                board.serial_number);
}

const char* describeNetworkState(std::uint8_t state) {
  switch (static_cast<canopen::NmtState>(state)) {
    case canopen::NmtState::kBootUp:
      return "just started";
    case canopen::NmtState::kStopped:
      return "stopped";
    case canopen::NmtState::kOperational:
      return "operational";
    case canopen::NmtState::kPreOperational:
      break;
  }
  return "pre-operational";
}

std::string describeNode(const CanScan::Node& node) {
  const int rate = node.period > 0 ? static_cast<int>(1 / node.period + 0.5) : 0;
  std::string words;
  if (node.protocol == CanScan::Protocol::kCanOpen) {
    words = describeNetworkState(node.state);
  } else {
    words = node.state == 1 ? "idle" : node.state == 8 ? "closed loop" : format("state %d", node.state);
    words += node.error == 0 ? ", no error" : format(", error 0x%X", node.error);
  }
  return rate > 0 ? words + format(", %d heartbeats a second", rate) : words;
}

// --- Pressure boards on a serial line ---

// Takes bytes until an answer of `address` is whole.
class HelloReader {
 public:
  explicit HelloReader(int address) : address_(address) {}

  bool take(const std::uint8_t* data, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) {
      if (data[i] != 0)
        frame_.push_back(data[i]);
      else if (takeFrame())
        return true;
    }
    return false;
  }
  const PressureIdentity& identity() const { return answer_.identity; }

 private:
  bool takeFrame() {
    const bool sound = decodeCobs(frame_.data(), frame_.size(), packet_) &&
                       decodePressureAnswer(packet_.data(), packet_.size(), answer_);
    frame_.clear();
    return sound && answer_.address == address_ && answer_.type == PressureType::kIdentity;
  }

  int address_;
  std::vector<std::uint8_t> frame_, packet_;
  PressureAnswer answer_;
};

PressureRequest makeHello() {
  PressureRequest hello;
  hello.type = PressureType::kHello;
  return hello;
}

bool sayHello(ByteStream& line, int address, Duration patience, PressureIdentity& identity) {
  std::vector<std::uint8_t> out;
  appendPressureRequest(static_cast<std::uint8_t>(address), makeHello(), out);
  std::uint8_t in[256];
  while (line.read(in, sizeof in, Duration{0}).count > 0) {
  }
  if (line.write(out.data(), out.size(), patience).status == StreamStatus::kClosed) return false;
  HelloReader reader(address);
  const Time deadline = line.now() + patience;
  for (Duration left = patience; left > Duration{0}; left = deadline - line.now()) {
    const StreamResult result = line.read(in, sizeof in, left);
    if (result.status == StreamStatus::kClosed) return false;
    if (!reader.take(in, result.count)) continue;
    identity = reader.identity();
    return true;
  }
  return false;
}

// --- CAN ---

class CanSearch {
 public:
  CanSearch(CanPort& port, IdRange ids) : port_(port), ids_(ids) {}

  void listen(double time, const ScanProgress& progress) {
    const Time begin = port_.now();
    const int slices = std::max(1, static_cast<int>(time / kListeningSlice + 0.5));
    for (int slice = 0; slice < slices && progress(slice, slices); ++slice)
      receiveUntil(begin + duration(kListeningSlice * (slice + 1)));
    findings_.frames = scan_.frames();
    for (const CanScan::Node& node : scan_.nodes()) add(node);
  }

  void ask(const ScanProgress& progress) {
    const int last = std::min(ids_.last, kMaxPressureAddress);
    for (int id = std::max(ids_.first, 1); id <= last && findings_.acknowledged && progress(id, last); ++id) {
      if (id <= canopen::kMaxNode) askNode(id);
      askBoard(id);
    }
  }

  CanFindings finish() {
    for (const CanScan::Identifier& stranger : scan_.unknown())
      if (!isAnswered(stranger)) findings_.strangers.push_back(format("0x%X", stranger.id));
    std::sort(findings_.devices.begin(), findings_.devices.end(),
              [](const BusDevice& a, const BusDevice& b) { return std::tie(a.type, a.id) < std::tie(b.type, b.id); });
    return findings_;
  }

 private:
  void add(const CanScan::Node& node) {
    const bool canopen = node.protocol == CanScan::Protocol::kCanOpen;
    findings_.devices.push_back(
        {canopen ? DeviceType::kCanopen : DeviceType::kOdrive, node.number, describeNode(node)});
  }

  BusDevice* find(DeviceType type, int id) {
    for (BusDevice& device : findings_.devices)
      if (device.type == type && device.id == id) return &device;
    return nullptr;
  }

  void receiveUntil(Time deadline) {
    CanFrame frame;
    for (Duration left = deadline - port_.now(); left > Duration{0}; left = deadline - port_.now())
      if (port_.receive(frame, left) == StreamStatus::kOk) scan_.take(frame, port_.now());
  }

  // The first frame that `wanted` takes.
  template <typename Wanted>
  bool exchange(const CanFrame& request, const Wanted& wanted) {
    if (port_.send(request, duration(kSendTime)) != StreamStatus::kOk) {
      findings_.acknowledged = false;
      return false;
    }
    const Time deadline = port_.now() + duration(kAnswerTime);
    CanFrame frame;
    for (Duration left = deadline - port_.now(); left > Duration{0}; left = deadline - port_.now()) {
      if (port_.receive(frame, left) != StreamStatus::kOk) continue;
      if (wanted(frame)) return true;
      scan_.take(frame, port_.now());
    }
    return false;
  }

  // A request to this node would have the identifier of a command to an ODrive that is on the bus.
  bool meansAnOdrive(int node) {
    return find(DeviceType::kOdrive, (static_cast<int>(canopen::kSdoRequestId) + node) >> kOdriveBits) != nullptr;
  }

  bool readNumber(int node, canopen::ObjectAddress object, std::uint32_t& value) {
    const auto number = static_cast<std::uint8_t>(node);
    return exchange(canopen::makeSdoUpload(number, object), [&](const CanFrame& frame) {
      canopen::SdoReply reply;
      if (!canopen::readSdoReply(frame, number, reply)) return false;
      value = reply.kind == canopen::SdoReply::Kind::kUpload ? canopen::loadNumber(reply.data.data(), reply.size) : 0;
      return true;
    });
  }

  void askNode(int node) {
    std::uint32_t vendor = 0, product = 0;
    if (meansAnOdrive(node) || !readNumber(node, kVendor, vendor)) return;
    readNumber(node, kProduct, product);
    const std::string words = format("vendor 0x%X, product 0x%X", vendor, product);
    if (BusDevice* heard = find(DeviceType::kCanopen, node))
      heard->words = words + ", " + heard->words;
    else
      findings_.devices.push_back({DeviceType::kCanopen, node, words + ", no heartbeat"});
  }

  void askBoard(int address) {
    std::vector<CanFrame> hello;
    appendPressureFrames(static_cast<std::uint8_t>(address), makeHello(), hello);
    PressureFrameReader reader(static_cast<std::uint8_t>(address));
    const auto takes = [&](const CanFrame& frame) {
      return reader.take(frame) == PressureFrameReader::Progress::kWhole &&
             reader.answer().type == PressureType::kIdentity;
    };
    if (exchange(hello.front(), takes))
      findings_.devices.push_back({DeviceType::kPressureBoard, address, describeBoard(reader.answer().identity)});
  }

  // Who answered when asked is no stranger.
  bool isAnswered(const CanScan::Identifier& identifier) {
    if (identifier.extended)
      return find(DeviceType::kPressureBoard, static_cast<int>(identifier.id >> 8 & 0xFF)) != nullptr;
    return find(DeviceType::kCanopen, static_cast<int>(identifier.id & canopen::kMaxNode)) != nullptr;
  }

  CanPort& port_;
  IdRange ids_;
  CanScan scan_;
  CanFindings findings_;
};

}  // namespace

const char* describe(DeviceType type) {
  switch (type) {
    case DeviceType::kDynamixel:
      return "servo";
    case DeviceType::kCanopen:
      return "CANopen drive";
    case DeviceType::kOdrive:
      return "ODrive axis";
    case DeviceType::kPressureBoard:
      break;
  }
  return "pressure board";
}

std::vector<BusDevice> findServos(ByteStream& line, int baud, Duration reply_timeout, IdRange ids,
                                  const ScanProgress& progress) {
  DynamixelBus bus(baud, reply_timeout);
  bus.attach(&line);
  std::vector<BusDevice> found;
  for (int id = ids.first; id <= ids.last && progress(id - ids.first, ids.last - ids.first + 1); ++id) {
    DynamixelBus::Identity identity;
    const BusStatus status = bus.ping(static_cast<std::uint8_t>(id), identity);
    if (status == BusStatus::kClosed) break;
    if (status == BusStatus::kOk) found.push_back({DeviceType::kDynamixel, id, describeServo(identity)});
  }
  return found;
}

std::vector<BusDevice> findBoards(ByteStream& line, int baud, Duration reply_timeout, IdRange ids,
                                  const ScanProgress& progress) {
  const std::size_t bytes =
      pressureFrameSize(PressureType::kHello, 0) + pressureFrameSize(PressureType::kIdentity, kMaxPressureChannels);
  const Duration patience = duration(kBitsPerByte * static_cast<double>(bytes) / baud + kTurnaround) + reply_timeout;
  std::vector<BusDevice> found;
  const int all = ids.last - ids.first + 1;
  for (int round = 0; round < kHelloRounds && found.empty(); ++round) {
    for (int id = ids.first; id <= ids.last && progress(round * all + id - ids.first, kHelloRounds * all); ++id) {
      PressureIdentity identity;
      if (sayHello(line, id, patience, identity))
        found.push_back({DeviceType::kPressureBoard, id, describeBoard(identity)});
    }
  }
  return found;
}

CanFindings findCanDevices(CanPort& port, double seconds, bool ask, IdRange ids, const ScanProgress& progress) {
  CanSearch search(port, ids);
  search.listen(seconds, progress);
  if (ask) search.ask(progress);
  return search.finish();
}

std::vector<BusDevice> listExpected(const HardwareDescription& hardware, int bus) {
  std::vector<BusDevice> expected;
  for (const int i : hardware.actuatorsOn(bus)) {
    const ActuatorDescription& a = hardware.actuators[static_cast<std::size_t>(i)];
    const auto same = [&](const BusDevice& device) { return device.type == a.device && device.id == a.id; };
    const auto device = std::find_if(expected.begin(), expected.end(), same);
    if (device == expected.end())
      expected.push_back({a.device, a.id, a.name});
    else
      device->words += ", " + a.name;
  }
  return expected;
}

}  // namespace sinew
