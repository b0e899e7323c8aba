#include "sinew/hardware/simulated_chamber.h"

#include <cmath>

namespace sinew {

// dp/dt = c s / V (source - p) - leak p, exactly over a step.
double SimulatedChamber::step(double dt, double share, double source) {
  const double inflow = share * parameters_.conductance / volume_;
  const double rate = inflow + leak_;
  if (rate <= 0) return 0;
  const double before = pressure_, rest = inflow * source / rate;
  const double decay = std::exp(-rate * dt);
  pressure_ = rest + (before - rest) * decay;
  const double mean = rest + (before - rest) * (1 - decay) / (rate * dt);
  return inflow * (source - mean) * dt * volume_;
}

void SimulatedChamber::setVolume(double volume) {
  pressure_ = (pressure_ + parameters_.atmosphere) * volume_ / volume - parameters_.atmosphere;
  volume_ = volume;
}

}  // namespace sinew
