#pragma once

#include "sinew/hardware/byte_stream.h"

namespace sinew {

/// Lets one thread sleep until a time of the steady clock or until another thread signals, whichever is first.
class WakeUp {
 public:
  WakeUp();
  ~WakeUp();
  WakeUp(const WakeUp&) = delete;
  WakeUp& operator=(const WakeUp&) = delete;

  /// From any thread; never waits.
  void signal();
  /// Returns whether a signal came, now or since the last wait.
  bool waitUntil(Time deadline);

 private:
  int event_;
};

}  // namespace sinew
