#pragma once

#include <ros/node_handle.h>
#include <sinew/TrackedObstacles.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "frame_finder.h"
#include "obstacle_predictor.h"
#include "parameters.h"
#include "refusal_log.h"
#include "ros_conversions.h"
#include "sinew/common/newest_wins.h"

namespace sinew {

/// What was last heard of one obstacle, in the robot's frame.
struct ObstacleSighting {
  ObstacleMotion motion;
  bool present = true;
  double receipt = -1;  ///< s, steady; negative before the first
  MessageStamp source;

  /// Whether it was there when last heard of, longer than `hold_time` [s] before `now` [s, steady].
  bool isLost(double now, double hold_time) const { return receipt >= 0 && present && now - receipt > hold_time; }
};

/// Receives poses of tracked obstacles in any frame, checks them, filters them, and hands the newest motion of each
/// obstacle to the cycle. A message that is refused changes nothing.
class ObstacleInbox {
 public:
  struct Settings {
    ObstaclePredictor::Settings predictor;
    double timeout = 0.5;    ///< s, older stamps are refused
    double hold_time = 0.5;  ///< s of silence after which an obstacle that was there is lost

    /// ~obstacle_timeout, ~obstacle_hold_time and the predictor's, each by its own name with `obstacle_` before it.
    static Settings read(const Parameters& parameters);
    /// Samples as they come: for one who knows the truth.
    static Settings makeTrusting();
  };

  /// For threads that may wait.
  struct Report {
    std::string name;
    bool heard = false, present = true, lost = false;
    double age = -1;  ///< s since the last sample that was believed, negative before the first
    std::uint64_t outliers = 0;
  };

  ObstacleInbox(ros::NodeHandle node, const std::string& topic, const Settings& settings,
                std::shared_ptr<const RobotModel> robot, const FrameFinder& frames);

  /// The reader's end of the exchange, one per obstacle of the robot.
  NewestWins<std::vector<ObstacleSighting>>& newest() { return newest_; }

  /// Writes where the obstacles of `newest().front()` are at `at` [s, steady]; those not heard of stay as they are.
  void predict(double at, std::vector<ObstacleState>& obstacles) const;
  /// Index of the first obstacle of `newest().front()` that is lost, -1 for none.
  int findLost(double now) const;

  std::vector<Report> report() const;
  std::string lastOutlier() const;  ///< in words, empty before the first

  const std::string& topic() const { return topic_; }
  const RefusalLog& refusals() const { return refusals_; }
  std::uint64_t accepted() const { return accepted_.load(std::memory_order_relaxed); }
  bool hasPublisher() const { return subscriber_.getNumPublishers() > 0; }

 private:
  void onObstacles(const TrackedObstacles& message);
  std::optional<Refusal> read(const TrackedObstacles& message);
  void take(std::size_t obstacle, const Pose& pose, double time, ObstacleSighting& sighting);
  void noteOutlier(std::size_t obstacle);

  Settings settings_;
  std::shared_ptr<const RobotModel> robot_;
  const FrameFinder& frames_;
  mutable std::mutex mutex_;
  std::vector<ObstacleSighting> sightings_;    // under mutex_
  std::vector<ObstaclePredictor> predictors_;  // under mutex_
  std::string last_outlier_;                   // under mutex_
  std::vector<int> named_;                     // callback thread only
  std::vector<Pose> poses_;                    // callback thread only
  NewestWins<std::vector<ObstacleSighting>> newest_;
  std::atomic<std::uint64_t> accepted_{0};
  RefusalLog refusals_;
  std::string topic_;
  ros::Subscriber subscriber_;
};

}  // namespace sinew
