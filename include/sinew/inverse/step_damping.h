#pragma once

namespace sinew {

/// Damping on the change of effort that holds a Gauss-Newton chase together where the linear problem misleads it. When
/// equilibrium moves the rows by more than a fraction of what the last step and the moving of obstacles moved them, the
/// step was too long for its linearisation and the damping rises; likewise when steps go to and fro beside a goal out
/// of reach, whose error outweighs what the linear problem leaves out. While steps come true it falls, and vanishes.
class StepDamping {
 public:
  /// `surprise`: norm over all rows of the motion at unchanged efforts, which the last linear problem took for zero
  /// [m]. `pushed`: norm of the motion that obstacles ask for beside it, of which what is linear is no surprise [m].
  void update(double surprise, double pushed);
  /// `motion`: norm over all rows of the step now taken [m]; `overshoots`: it takes back the step before, on the way
  /// to a goal that neither reaches.
  void recordStep(double motion, bool overshoots = false) {
    last_motion_ = motion;
    overshoots_ = overshoots;
  }
  void reset() { *this = StepDamping(); }

  double value() const { return value_; }  ///< relative to the best-driven direction

 private:
  double last_motion_ = 0;
  bool overshoots_ = false;
  double value_ = 0;
};

}  // namespace sinew
