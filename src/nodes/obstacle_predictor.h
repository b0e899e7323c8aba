#pragma once

#include <cstdint>

#include "sinew/common/types.h"

namespace sinew {

/// A pose that moves on evenly.
struct ObstacleMotion {
  Vec3 position = Vec3::Zero();  ///< m
  Eigen::Quaterniond orientation = Eigen::Quaterniond::Identity();
  Vec3 velocity = Vec3::Zero();   ///< m/s
  Vec3 turn_rate = Vec3::Zero();  ///< rad/s, in the axes of the poses' frame
  double time = 0;                ///< s, when position and orientation hold

  /// The pose at `at` [s], carried on for `horizon` [s] at most and never back.
  Pose calcPose(double at, double horizon) const;
};

/// Where an obstacle is and how it moves, from poses that a tracker sees now and then, late and noisy.
///
/// A filter of fading memory (alpha-beta, critically damped): with d the difference between a sample and what was
/// predicted for it, dt since the sample before and theta = exp(-dt / filter_time),
///   position += (1 - theta^2) d,   velocity += (1 - theta)^2 / dt d,
/// and likewise for the turn about the origin. It follows an even motion without lag. A sample farther off than
/// `max_jump` or `max_turn` is taken for an outlier, until `jump_samples` of them in a row agree.
class ObstaclePredictor {
 public:
  struct Settings {
    double filter_time = 0.05;  ///< s, 0 takes every sample as it is
    double max_speed = 0.5;     ///< m/s that a prediction may have
    double max_turn_rate = 5;   ///< rad/s, likewise
    double max_jump = 0.03;     ///< m between a sample and its prediction
    double max_turn = 0.5;      ///< rad, likewise
    int jump_samples = 5;       ///< 1, outliers in a row that are believed
    double memory = 0.5;        ///< s without a sample after which the next one begins anew
    double horizon = 0.1;       ///< s by which a prediction may go beyond the last sample
  };

  enum class Verdict {
    kTaken,    ///< the motion has been updated
    kBegun,    ///< the motion begins anew, at rest
    kOutlier,  ///< not believed, and nothing changed
    kLate      ///< not newer than the one before: nothing changed
  };

  explicit ObstaclePredictor(const Settings& settings) : settings_(settings) {}

  /// A pose seen at `time` [s].
  Verdict add(double time, const Pose& pose);
  /// Without a past: the next sample begins anew.
  void forget() { begun_ = false; }

  const ObstacleMotion& motion() const { return motion_; }
  std::uint64_t outliers() const { return outliers_; }  ///< since construction
  /// How far the last sample was from its prediction.
  double lastJump() const { return last_jump_; }  ///< m
  double lastTurn() const { return last_turn_; }  ///< rad

 private:
  Verdict begin(double time, const Pose& pose);
  Verdict addOutlier(double time, const Pose& pose);
  void filter(double time, const Vec3& off, const Vec3& turned_off);

  Settings settings_;
  bool begun_ = false;
  ObstacleMotion motion_;
  int outlier_run_ = 0;
  ObstacleMotion last_outlier_;
  std::uint64_t outliers_ = 0;
  double last_jump_ = 0, last_turn_ = 0;
};

}  // namespace sinew
