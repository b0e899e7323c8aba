#include "sinew/hardware/simulated_pressure_node.h"

#include <string>

#include "sinew/common/config_error.h"

namespace sinew {

SimulatedPressureNode::SimulatedPressureNode(int address, std::vector<int> channels,
                                             const SimulatedPressureBoard::Parameters& parameters)
    : board_(address, parameters), channels_(std::move(channels)) {
  for (const int channel : channels_)
    if (channel < 0 || channel >= board_.size())
      throw ConfigError("channel of simulated pressure board " + std::to_string(address), std::to_string(channel),
                        "0 to " + std::to_string(board_.size() - 1));
}

void SimulatedPressureNode::take(const CanFrame& frame, Time, std::vector<CanFrame>& out) {
  board_.take(frame, out);
}

}  // namespace sinew
