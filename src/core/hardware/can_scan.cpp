#include "sinew/hardware/can_scan.h"

#include "sinew/hardware/odrive_messages.h"

namespace sinew {
namespace {

// CiA 301: identifiers and states of network management.
constexpr std::uint32_t kHeartbeat = 0x700, kMaxNode = 0x7F;
constexpr std::uint8_t kBootUp = 0, kStopped = 4, kOperational = 5, kPreOperational = 0x7F;
constexpr std::size_t kMaxIdentifiers = 4096;  // kept apart; more come only from noise
constexpr std::uint8_t kMaxAxisState = 14;     // ODrive documentation, AxisState

bool isNetworkState(std::uint8_t state) {
  return state == kBootUp || state == kStopped || state == kOperational || state == kPreOperational;
}

}  // namespace

void CanScan::take(const CanFrame& frame, Time now) {
  ++frames_;
  const std::pair<bool, std::uint32_t> key{frame.extended, frame.id};
  if (identifiers_.size() >= kMaxIdentifiers && identifiers_.count(key) == 0) return;
  Identifier& identifier = identifiers_[key];
  identifier.id = frame.id;
  identifier.extended = frame.extended;
  identifier.size = frame.size;
  ++identifier.frames;
  if (frame.extended || frame.remote) return;
  OdriveHeartbeat axis;
  const bool in_range = frame.id > kHeartbeat && frame.id <= kHeartbeat + kMaxNode;
  if (in_range && frame.size == 1 && isNetworkState(frame.data[0])) {
    beat(Protocol::kCanOpen, static_cast<int>(frame.id - kHeartbeat), frame.data[0], 0, now);
  } else if (odriveCommand(frame) == OdriveCommand::kHeartbeat && odriveNode(frame) <= kMaxOdriveNode &&
             decodeOdrive(frame, axis) && axis.state > 0 && axis.state <= kMaxAxisState) {
    beat(Protocol::kOdrive, odriveNode(frame), axis.state, axis.error, now);
  }
}

void CanScan::beat(Protocol protocol, int number, std::uint8_t state, std::uint32_t error, Time now) {
  Heard& heard = heard_[{protocol, number}];
  Node& node = heard.node;
  node.protocol = protocol;
  node.number = number;
  node.state = state;
  node.error = error;
  node.booted = node.booted || (protocol == Protocol::kCanOpen && state == kBootUp);
  if (node.heartbeats++ > 0) node.period = seconds(now - heard.last);
  heard.last = now;
}

std::vector<CanScan::Node> CanScan::nodes() const {
  std::vector<Node> nodes;
  for (const auto& heard : heard_) nodes.push_back(heard.second.node);
  return nodes;
}

// Of CANopen the predefined connection set: function code in the upper 4 bits, node in the lower 7.
bool CanScan::isOwned(const Identifier& identifier) const {
  if (identifier.extended) return false;
  const auto axis = static_cast<int>(identifier.id >> 5), node = static_cast<int>(identifier.id & kMaxNode);
  return heard_.count({Protocol::kOdrive, axis}) > 0 || (node > 0 && heard_.count({Protocol::kCanOpen, node}) > 0);
}

std::vector<CanScan::Identifier> CanScan::unknown() const {
  std::vector<Identifier> out;
  for (const auto& entry : identifiers_)
    if (!isOwned(entry.second)) out.push_back(entry.second);
  return out;
}

}  // namespace sinew
