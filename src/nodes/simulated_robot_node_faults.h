#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "sinew/hardware/simulated_hardware.h"

namespace sinew {

/// Makes the simulated devices and their lines fail on request, and counts the requests.
class FaultDesk {
 public:
  /// `disconnect` takes the line of a bus away for a time [s].
  FaultDesk(SimulatedHardware& hardware, const LineFaults& line, std::function<void(int bus, double time)> disconnect);

  struct Answer {
    bool success;
    std::string message;
  };
  /// Field by field as in InjectFault.srv.
  Answer inject(const std::string& fault, const std::string& actuator, double value);

  /// Requests carried out so far, by fault.
  const std::map<std::string, std::uint64_t>& counts() const { return counts_; }
  LineFaultCounts lineCounts() const { return hardware_.lineFaultCounts(); }

 private:
  Answer injectInLines(const std::string& fault, double value);
  Answer injectInActuators(const std::string& fault, const std::string& actuator, double value);
  void injectInActuator(const std::string& fault, int actuator, double value);
  Answer injectInSupply(double value);
  Answer takeLinesAway(const std::string& name, double value);

  SimulatedHardware& hardware_;
  LineFaults line_;
  std::function<void(int, double)> disconnect_;
  std::map<std::string, std::uint64_t> counts_;
};

}  // namespace sinew
