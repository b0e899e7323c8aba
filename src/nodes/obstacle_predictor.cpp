#include "obstacle_predictor.h"

#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

/// The rotation by `turn` [rad], a vector along its axis.
Eigen::Quaterniond makeTurn(const Vec3& turn) {
  const double angle = turn.norm();
  return angle > 0 ? Eigen::Quaterniond(Eigen::AngleAxisd(angle, turn / angle)) : Eigen::Quaterniond::Identity();
}

/// The shorter turn [rad] that leads from one orientation to the other.
Vec3 calcTurn(const Eigen::Quaterniond& from, const Eigen::Quaterniond& to) {
  Eigen::Quaterniond turn = to * from.conjugate();
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();
  return sine > 0 ? Vec3(2 * std::atan2(sine, turn.w()) / sine * turn.vec()) : Vec3::Zero();
}

void moveOn(double duration, ObstacleMotion& motion) {
  motion.position += duration * motion.velocity;
  motion.orientation = (makeTurn(duration * motion.turn_rate) * motion.orientation).normalized();
  motion.time += duration;
}

ObstacleMotion makeRest(double time, const Pose& pose) {
  ObstacleMotion motion;
  motion.position = pose.translation();
  motion.orientation = Eigen::Quaterniond(pose.linear()).normalized();
  motion.time = time;
  return motion;
}

Vec3 calcCapped(const Vec3& vector, double length) {
  const double norm = vector.norm();
  return norm > length ? Vec3(length / norm * vector) : vector;
}

}  // namespace

Pose ObstacleMotion::calcPose(double at, double horizon) const {
  ObstacleMotion then = *this;
  moveOn(std::max(0.0, std::min(horizon, at - time)), then);
  Pose pose = Pose::Identity();
  pose.linear() = then.orientation.toRotationMatrix();
  pose.translation() = then.position;
  return pose;
}

ObstaclePredictor::Verdict ObstaclePredictor::add(double time, const Pose& pose) {
  if (!begun_) return begin(time, pose);
  const double passed = time - motion_.time;
  if (passed <= 0) return Verdict::kLate;
  if (passed > settings_.memory) return begin(time, pose);
  const Pose predicted = motion_.calcPose(time, settings_.memory);
  const Vec3 off = pose.translation() - predicted.translation();
  const Vec3 turned_off = calcTurn(Eigen::Quaterniond(predicted.linear()), Eigen::Quaterniond(pose.linear()));
  last_jump_ = off.norm();
  last_turn_ = turned_off.norm();
  if (last_jump_ > settings_.max_jump || last_turn_ > settings_.max_turn) return addOutlier(time, pose);
  filter(time, off, turned_off);
  return Verdict::kTaken;
}

ObstaclePredictor::Verdict ObstaclePredictor::begin(double time, const Pose& pose) {
  motion_ = makeRest(time, pose);
  outlier_run_ = 0;
  begun_ = true;
  return Verdict::kBegun;
}

ObstaclePredictor::Verdict ObstaclePredictor::addOutlier(double time, const Pose& pose) {
  ++outliers_;
  const ObstacleMotion outlier = makeRest(time, pose);
  const bool agrees = outlier_run_ > 0 && (outlier.position - last_outlier_.position).norm() <= settings_.max_jump &&
                      calcTurn(last_outlier_.orientation, outlier.orientation).norm() <= settings_.max_turn;
  if (agrees && time <= last_outlier_.time) return Verdict::kLate;
  outlier_run_ = agrees ? outlier_run_ + 1 : 1;
  last_outlier_ = outlier;
  return outlier_run_ < settings_.jump_samples ? Verdict::kOutlier : begin(time, pose);
}

void ObstaclePredictor::filter(double time, const Vec3& off, const Vec3& turned_off) {
  const double passed = time - motion_.time;
  const double fading = std::exp(-passed / settings_.filter_time);
  const double alpha = 1 - fading * fading;
  const double beta = (1 - fading) * (1 - fading);
  moveOn(passed, motion_);
  motion_.time = time;
  motion_.position += alpha * off;
  motion_.orientation = (makeTurn(alpha * turned_off) * motion_.orientation).normalized();
  motion_.velocity = calcCapped(motion_.velocity + beta / passed * off, settings_.max_speed);
  motion_.turn_rate = calcCapped(motion_.turn_rate + beta / passed * turned_off, settings_.max_turn_rate);
  outlier_run_ = 0;
}

}  // namespace sinew
