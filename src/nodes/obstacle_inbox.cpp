#include "obstacle_inbox.h"

#include <ros/console.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "real_time.h"

namespace sinew {

ObstacleInbox::Settings ObstacleInbox::Settings::read(const Parameters& parameters) {
  Settings settings;
  ObstaclePredictor::Settings& predictor = settings.predictor;
  settings.timeout = parameters.numberOr("obstacle_timeout", settings.timeout, 1e-3, 1e6);
  settings.hold_time = parameters.numberOr("obstacle_hold_time", settings.hold_time, 1e-3, 1e6);
  predictor.filter_time = parameters.numberOr("obstacle_filter_time", predictor.filter_time, 0, 10);
  predictor.horizon = parameters.numberOr("obstacle_horizon", predictor.horizon, 0, 1);
  predictor.max_speed = parameters.numberOr("obstacle_max_speed", predictor.max_speed, 0, 100);
  predictor.max_turn_rate = parameters.numberOr("obstacle_max_turn_rate", predictor.max_turn_rate, 0, 100);
  predictor.max_jump = parameters.numberOr("obstacle_max_jump", predictor.max_jump, 1e-4, kFarthest);
  predictor.max_turn = parameters.numberOr("obstacle_max_turn", predictor.max_turn, 1e-2, 7);
  predictor.jump_samples = parameters.integerOr("obstacle_jump_samples", predictor.jump_samples, 1, 1000);
  predictor.memory = settings.hold_time;
  return settings;
}

ObstacleInbox::Settings ObstacleInbox::Settings::makeTrusting() {
  Settings settings;
  settings.predictor.filter_time = 0;
  settings.predictor.horizon = 0;
  settings.predictor.max_jump = settings.predictor.max_turn = std::numeric_limits<double>::infinity();
  settings.timeout = settings.hold_time = std::numeric_limits<double>::infinity();
  return settings;
}

ObstacleInbox::ObstacleInbox(ros::NodeHandle node, const std::string& topic, const Settings& settings,
                             std::shared_ptr<const RobotModel> robot, const FrameFinder& frames)
    : settings_(settings),
      robot_(std::move(robot)),
      frames_(frames),
      sightings_(robot_->obstacles().size()),
      predictors_(sightings_.size(), ObstaclePredictor(settings.predictor)),
      newest_(sightings_),
      topic_(node.resolveName(topic)) {
  subscriber_ = node.subscribe(topic, 10, &ObstacleInbox::onObstacles, this, ros::TransportHints().tcpNoDelay());
}

void ObstacleInbox::predict(double at, std::vector<ObstacleState>& obstacles) const {
  const std::vector<ObstacleSighting>& sightings = newest_.front();
  for (std::size_t i = 0; i < sightings.size(); ++i) {
    if (sightings[i].receipt < 0) continue;
    obstacles[i].present = sightings[i].present;
    if (sightings[i].present) obstacles[i].pose = sightings[i].motion.calcPose(at, settings_.predictor.horizon);
  }
}

int ObstacleInbox::findLost(double now) const {
  const std::vector<ObstacleSighting>& sightings = newest_.front();
  const auto lost = std::find_if(sightings.begin(), sightings.end(), [&](const ObstacleSighting& sighting) {
    return sighting.isLost(now, settings_.hold_time);
  });
  return lost == sightings.end() ? -1 : static_cast<int>(lost - sightings.begin());
}

std::vector<ObstacleInbox::Report> ObstacleInbox::report() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const double now = steadyNow();
  std::vector<Report> reports;
  for (std::size_t i = 0; i < sightings_.size(); ++i) {
    const Obstacle& obstacle = robot_->obstacles()[i];
    if (!obstacle.tracked) continue;
    const ObstacleSighting& sighting = sightings_[i];
    const bool heard = sighting.receipt >= 0;
    reports.push_back({obstacle.name, heard, sighting.present, sighting.isLost(now, settings_.hold_time),
                       heard ? now - sighting.receipt : -1.0, predictors_[i].outliers()});
  }
  return reports;
}

std::string ObstacleInbox::lastOutlier() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return last_outlier_;
}

void ObstacleInbox::onObstacles(const TrackedObstacles& message) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (const std::optional<Refusal> refusal = read(message)) {
    refusals_.add(*refusal);
    ROS_WARN_STREAM_THROTTLE(5.0, "refused a message on " << topic_ << ": " << refusal->words);
    return;
  }
  accepted_.fetch_add(1, std::memory_order_relaxed);
  newest_.write(sightings_);
}

std::optional<Refusal> ObstacleInbox::read(const TrackedObstacles& message) {
  if (auto refusal = checkObstacles(message, *robot_, named_)) return refusal;
  if (auto refusal = checkStamp(message.header, settings_.timeout)) return refusal;
  Pose to_robot;
  if (auto refusal = frames_.find(message.header, to_robot)) return refusal;
  poses_.clear();
  for (std::size_t i = 0; i < named_.size(); ++i) {
    poses_.push_back(message.present[i] ? to_robot * toPose(message.pose[i]) : Pose::Identity());
    if (poses_.back().translation().norm() <= kFarthest) continue;
    return Refusal{RefusalReason::kJump, "obstacle '" + message.name[i] + "' is more than a kilometre from the robot"};
  }
  // The stamp tells how old the poses are; what ages from here on does so by the steady clock.
  const double age = message.header.stamp.isZero() ? 0 : (ros::Time::now() - message.header.stamp).toSec();
  const double now = steadyNow();
  for (std::size_t i = 0; i < named_.size(); ++i) {
    const auto obstacle = static_cast<std::size_t>(named_[i]);
    ObstacleSighting& sighting = sightings_[obstacle];
    sighting.source = {message.header.stamp, message.header.seq};
    if (message.present[i]) {
      take(obstacle, poses_[i], now - std::max(0.0, age), sighting);
    } else {
      predictors_[obstacle].forget();
      sighting.receipt = now;
      sighting.present = false;
    }
  }
  return std::nullopt;
}

void ObstacleInbox::take(std::size_t obstacle, const Pose& pose, double time, ObstacleSighting& sighting) {
  switch (predictors_[obstacle].add(time, pose)) {
    case ObstaclePredictor::Verdict::kOutlier:
      noteOutlier(obstacle);
      return;
    case ObstaclePredictor::Verdict::kLate:
      return;
    case ObstaclePredictor::Verdict::kTaken:
    case ObstaclePredictor::Verdict::kBegun:
      sighting.motion = predictors_[obstacle].motion();
      sighting.receipt = steadyNow();
      sighting.present = true;
  }
}

void ObstacleInbox::noteOutlier(std::size_t obstacle) {
  const ObstaclePredictor& predictor = predictors_[obstacle];
  std::ostringstream words;
  words << "obstacle '" << robot_->obstacles()[obstacle].name << "' jumps by " << predictor.lastJump() << " m and "
        << predictor.lastTurn() << " rad";
  last_outlier_ = words.str();
  ROS_WARN_STREAM_THROTTLE(5.0, last_outlier_ << ": not believed yet");
}

}  // namespace sinew
