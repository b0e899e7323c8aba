#pragma once

#include <string>

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// An emergency stop that the kernel shows as an input device (/dev/input/event...): a USB button, a foot switch, a
/// wireless key. Any of its keys that is down is a stop, and so is a device that cannot be read: unplugging it stops
/// the robot.
class EmergencyStopInput {
 public:
  explicit EmergencyStopInput(std::string path) : path_(std::move(path)) {}
  ~EmergencyStopInput();
  EmergencyStopInput(const EmergencyStopInput&) = delete;
  EmergencyStopInput& operator=(const EmergencyStopInput&) = delete;

  /// Waits up to `timeout` for something to happen, and takes it in; opens the device when it is not.
  void update(Duration timeout);
  bool pressed() const { return fd_ < 0 || keys_down_ > 0; }
  /// Whether the device is there.
  bool present() const { return fd_ >= 0; }

 private:
  void open();
  void close();
  void takeEvents();
  void countKeysDown();

  std::string path_;
  int fd_ = -1;
  int keys_down_ = 0;
};

}  // namespace sinew
