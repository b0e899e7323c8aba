#pragma once

#include <geometry_msgs/PoseStamped.h>
#include <ros/node_handle.h>

#include <atomic>
#include <memory>
#include <string>
#include <vector>

#include "frame_finder.h"
#include "parameters.h"
#include "refusal_log.h"
#include "ros_conversions.h"
#include "sinew/common/newest_wins.h"

namespace sinew {

/// The newest target of every effector, in the robot's frame.
struct TargetSet {
  VecX positions;              ///< 3 x effectors [m]
  std::vector<bool> targeted;  ///< per effector: whether it has had a target
  std::vector<MessageStamp> source;
  std::vector<int> topic;   ///< index into TargetInbox::topics()
  std::uint64_t epoch = 0;  ///< calls of `forget` before it was received
};

/// Receives targets in any frame, `targets` (EffectorTargets) for several effectors and `target_pose` (PoseStamped) for
/// the one that ~pose_effector names, checks them, and hands the newest to the cycle. A message that is refused changes
/// nothing.
class TargetInbox {
 public:
  /// Parameters: ~pose_effector (first effector), ~target_timeout (s), ~max_target_jump (m, 0 for any).
  TargetInbox(ros::NodeHandle node, const Parameters& parameters, std::shared_ptr<const RobotModel> robot,
              const FrameFinder& frames);

  /// The cycle's end of the exchange; targets of an epoch before the present one do not count.
  NewestWins<TargetSet>& newest() { return newest_; }
  std::uint64_t epoch() const { return epoch_.load(std::memory_order_acquire); }

  /// Every effector is without a target until its next one. Any thread.
  void forget() { epoch_.fetch_add(1, std::memory_order_acq_rel); }

  const std::vector<std::string>& topics() const { return topics_; }
  const RefusalLog& refusals() const { return refusals_; }
  std::uint64_t accepted() const { return accepted_.load(std::memory_order_relaxed); }

 private:
  enum Topic { kTargets, kTargetPose };

  void onTargets(const EffectorTargets& message);
  void onTargetPose(const geometry_msgs::PoseStamped& message);
  void receive(const EffectorTargets& message, Topic topic);
  std::optional<Refusal> read(const EffectorTargets& message, Topic topic);
  std::optional<Refusal> checkPosition(int effector, const Vec3& position) const;
  void noteOrientation(const EffectorTargets& message);

  std::shared_ptr<const RobotModel> robot_;
  const FrameFinder& frames_;
  std::string pose_effector_;
  double timeout_;   // s
  double max_jump_;  // m, 0 for any

  TargetSet targets_;  // as received so far; callback thread only
  std::vector<int> effectors_;
  std::vector<Vec3> positions_;
  bool orientation_noted_ = false;
  NewestWins<TargetSet> newest_;
  std::atomic<std::uint64_t> epoch_{0};
  std::atomic<std::uint64_t> accepted_{0};
  RefusalLog refusals_;
  std::vector<std::string> topics_;
  ros::Subscriber targets_subscriber_, pose_subscriber_;
};

}  // namespace sinew
