#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sinew/hardware/simulated_servo_bus.h"

namespace sinew {

/// Makes the simulated servos and their line fail on request, and counts the requests.
class FaultDesk {
 public:
  /// `actuators`: the name of each servo of the bus, in its order. `disconnect` takes the line away for a time [s].
  FaultDesk(SimulatedServoBus& bus, std::vector<std::string> actuators, const LineFaults& line,
            std::function<void(double)> disconnect);

  struct Answer {
    bool success;
    std::string message;
  };
  /// Field by field as in InjectFault.srv.
  Answer inject(const std::string& fault, const std::string& actuator, double value);

  /// Requests carried out so far, by fault.
  const std::map<std::string, std::uint64_t>& counts() const { return counts_; }
  LineFaultCounts lineCounts() const { return bus_.lineFaultCounts(); }

 private:
  Answer injectInLine(const std::string& fault, double value);
  Answer injectInServos(const std::string& fault, const std::string& actuator, double value);
  Answer injectInSupply(const std::string& fault, double value);

  SimulatedServoBus& bus_;
  std::vector<std::string> actuators_;
  LineFaults line_;
  std::function<void(double)> disconnect_;
  std::map<std::string, std::uint64_t> counts_;
};

}  // namespace sinew
