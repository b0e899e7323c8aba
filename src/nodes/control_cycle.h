#pragma once

#include <array>
#include <atomic>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "actuator_inbox.h"
#include "body_publisher.h"
#include "control_mode.h"
#include "control_session.h"
#include "control_settings.h"
#include "cycle_publisher.h"
#include "obstacle_inbox.h"
#include "real_time.h"
#include "renewal_thread.h"
#include "sinew/inverse/overload_ladder.h"
#include "target_inbox.h"

namespace sinew {

/// The cycle of an inverse controller, on a thread of its own by the steady clock: takes what the inboxes hold, steps
/// the controller, hands command and report over, and linearises ahead. It takes no memory, waits for nobody and says
/// nothing. When time is short it leaves out what the ladder tells it to; a command goes out every period.
class ControlCycle {
 public:
  struct Inboxes {
    TargetInbox& targets;
    ObstacleInbox& obstacles;
    ActuatorInbox& actuators;
  };

  ControlCycle(const ControlSettings& settings, std::shared_ptr<const RobotModel> robot, const Inboxes& inboxes,
               ControlMode& mode, ControlSession& session, CyclePublisher& publisher, BodyPublisher& body);
  ~ControlCycle();
  ControlCycle(const ControlCycle&) = delete;
  ControlCycle& operator=(const ControlCycle&) = delete;

  void start();

 private:
  void runAll();
  void run(const PeriodicWakeUp& wake_up);
  void readInboxes();
  void updateObstacles();
  void act(Mode mode);
  void follow();
  void rest(const char* reason);
  void control();
  void updateTargets();
  const char* findReasonToStop() const;
  void step();
  void holdIfNotFinite();
  void holdForObstacle();
  void recordCommand();
  void report(std::uint8_t status, const char* reason);
  void linearise(bool enabled);
  void handCommand();
  void updateLevel(double taken);
  void handCycle(Mode mode, const PeriodicWakeUp& wake_up, double end);
  void listInputs(CycleRecord& record) const;

  const ControlSettings& settings_;
  std::shared_ptr<const RobotModel> robot_;
  Inboxes inboxes_;
  ControlMode& mode_;
  ControlSession& session_;
  CyclePublisher& publisher_;
  BodyPublisher& body_;
  RenewalThread renewal_;
  OverloadLadder ladder_;
  std::vector<std::string> lost_words_;  // per obstacle
  int lost_ = -1;                        // obstacle, -1 for none
  double begin_ = -1, period_ = 0;       // s, steady; from the begin before
  double answered_ = 0;                  // s after it was due, when the cycle's command was handed over
  std::uint64_t cycle_ = 0;
  std::uint64_t body_divider_;
  int since_renewal_ = 0;     // cycles since the last one was begun
  double renewal_cost_ = -1;  // s of the processor, mean of the last ones; negative before the first
  std::uint8_t status_ = ControllerState::DISABLED;
  const char* reason_ = "";
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sinew
