#include "simulated_robot_node_winches.h"

namespace sinew {

void calcReeledIn(const SimulatedServoBus& bus, const std::vector<Winch>& winches, VecX& reeled_in) {
  for (int i = 0; i < bus.size(); ++i) {
    reeled_in[i] = winches[static_cast<size_t>(i)].reel_radius * bus.shaftAngle(i);
  }
}

void applyTension(const VecX& tension, const std::vector<Winch>& winches, SimulatedServoBus& bus) {
  for (int i = 0; i < bus.size(); ++i) {
    bus.setLoadTorque(i, -winches[static_cast<size_t>(i)].reel_radius * tension[i]);
  }
}

}  // namespace sinew
