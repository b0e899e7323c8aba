#pragma once

namespace sinew {

/// The air in a soft robot's chamber behind its valves: isothermal, with flows in proportion to the pressure that
/// drives them, so that each open path pulls the pressure exponentially towards its own. Pressures in Pa gauge.
class SimulatedChamber {
 public:
  struct Parameters {
    double volume = 50e-6;        ///< m3
    double conductance = 2.5e-4;  ///< m3/s through a valve fully open
    double atmosphere = 101325;   ///< Pa absolute
  };

  SimulatedChamber() : SimulatedChamber(Parameters()) {}
  explicit SimulatedChamber(const Parameters& parameters) : parameters_(parameters), volume_(parameters.volume) {}

  double pressure() const { return pressure_; }
  double volume() const { return volume_; }

  /// Moves on by `dt` [s] with a valve open by `share` (0 to 1) towards `source`. Returns the air taken from the source
  /// [Pa m3].
  double step(double dt, double share, double source);

  /// Rate [1/s] at which the pressure falls by itself.
  void setLeak(double rate) { leak_ = rate; }
  /// Presses the chamber to another volume [m3], as a load on the robot does.
  void setVolume(double volume);

 private:
  Parameters parameters_;
  double volume_;
  double pressure_ = 0;
  double leak_ = 0;
};

}  // namespace sinew
