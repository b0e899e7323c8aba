#pragma once

#include <string>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

/// A path of one effector, run through once every `period`, or once in all when it comes from a file.
struct TrajectoryTiming {
  double period = 8;  ///< s a turn
  double turns = 2;   ///< 1
};

/// Target positions of some effectors over time, in the robot's frame. Immutable.
class TargetTrajectory {
 public:
  /// Horizontal circle around `centre` [m], from the +x side towards +y.
  static TargetTrajectory makeCircle(const std::string& effector, const Vec3& centre, double radius,
                                     const TrajectoryTiming& timing);

  /// Horizontal square inscribed in the circle of `radius` [m] around `centre` [m], one corner in +x, at constant
  /// speed.
  static TargetTrajectory makeSquare(const std::string& effector, const Vec3& centre, double radius,
                                     const TrajectoryTiming& timing);

  /// The body bends to an S that turns around its axis: `tip` runs on a horizontal circle of `radius` [m] around its
  /// centre, and `middle` on one of `middle_radius` [m] on the opposite side.
  static TargetTrajectory makeSShape(const std::string& tip, const Vec3& tip_centre, double radius,
                                     const std::string& middle, const Vec3& middle_centre, double middle_radius,
                                     const TrajectoryTiming& timing);

  /// Columns `t` [s], rising, and `target_NAME_x`, `target_NAME_y`, `target_NAME_z` [m] per effector, separated by
  /// commas, with a line of names first; other columns do not matter. Linear between the rows. Throws ConfigError.
  static TargetTrajectory readCsv(const std::string& path);

  const std::vector<std::string>& effectors() const { return effectors_; }
  double duration() const { return duration_; }  ///< s

  /// Positions [m] at `time` [s], one per effector; before the start and after the end those of start and end.
  void calcPositions(double time, std::vector<Vec3>& positions) const;

  /// Velocities [m/s] at `time`, by central differences over a millisecond; one-sided at the ends.
  void calcVelocities(double time, std::vector<Vec3>& velocities) const;

 private:
  /// One effector: a closed polyline or circle, or samples in time.
  struct Path {
    enum class Shape { kCircle, kPolygon, kSamples } shape = Shape::kSamples;
    Vec3 centre = Vec3::Zero();  ///< m
    double radius = 0;           ///< m
    double phase = 0;            ///< rad
    std::vector<Vec3> points;    ///< m, corners or samples
  };

  Vec3 calcPosition(const Path& path, double time) const;
  Vec3 calcSample(const Path& path, double time) const;

  std::vector<std::string> effectors_;
  std::vector<Path> paths_;
  std::vector<double> times_;  ///< s, of samples
  double period_ = 1;          ///< s
  double duration_ = 0;        ///< s
};

/// From `start` [m] at rest to `end` [m] with `velocity` [m/s] in `duration` [s], accelerations zero at both ends:
/// p(s) = start + (end - start) (10 s^3 - 15 s^4 + 6 s^5) + duration velocity (-4 s^3 + 7 s^4 - 3 s^5), s =
/// time/duration.
Vec3 calcRamp(const Vec3& start, const Vec3& end, const Vec3& velocity, double duration, double time);

}  // namespace sinew
