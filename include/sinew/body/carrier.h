#pragma once

#include "sinew/common/types.h"

namespace sinew {

/// Where a driven rail has carried the whole robot: one degree of freedom beside those of the body, whose positions,
/// pull points and fixed nodes among them, are told in a frame that travels along.
class Carrier {
 public:
  explicit Carrier(const Vec3& direction) : direction_(direction.normalized()) {}

  double travel() const { return travel_; }                 ///< m
  Vec3 offset() const { return travel_ * direction_; }      ///< m, of the robot's frame
  const Vec3& direction() const { return direction_; }      ///< 1
  Vec3 acceleration() const { return pull_ * direction_; }  ///< m/s2, of the present step

  /// As of `FemBody`: a step may be repeated or abandoned until it ends.
  void beginStep() { start_ = travel_; }
  void abandonStep() { travel_ = start_; }
  void endStep(double speed) { speed_ = speed, pull_ = 0; }
  double calcSpeed(double period) const { return (travel_ - start_) / period; }  ///< m/s since `beginStep`
  /// The step of `period` [s] will end at `goal` [m].
  void accelerate(double goal, double period) { pull_ = ((goal - start_) / period - speed_) / period; }

  void advance(double way) { travel_ += way; }
  /// At rest at `travel`.
  void place(double travel) { travel_ = start_ = travel, speed_ = pull_ = 0; }

 private:
  Vec3 direction_;
  double travel_ = 0, start_ = 0;  // m
  double speed_ = 0;               // m/s, of the last step
  double pull_ = 0;                // m/s2
};

}  // namespace sinew
