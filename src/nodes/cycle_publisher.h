#pragma once

#include <ros/node_handle.h>
#include <semaphore.h>

#include <array>
#include <atomic>
#include <memory>
#include <thread>

#include "control_summary.h"
#include "cycle_record.h"
#include "ring_queue.h"
#include "sinew/common/newest_wins.h"
#include "stage_statistics.h"

namespace sinew {

/// Publishes `actuator_command` and `controller_state` from a thread of its own, every one of them in order: making and
/// sending messages takes memory and locks. It stands just above the cycle thread, so that a command does not wait for
/// the work that follows it.
class CyclePublisher {
 public:
  struct Settings {
    double rate;   ///< Hz
    int priority;  ///< of the cycle thread
  };

  CyclePublisher(ros::NodeHandle node, const Settings& settings, std::shared_ptr<const RobotModel> robot,
                 const CycleInput& input, const CycleOutput& output);
  ~CyclePublisher();
  CyclePublisher(const CyclePublisher&) = delete;
  CyclePublisher& operator=(const CyclePublisher&) = delete;

  /// Cycle thread: a record to fill and hand over; null while the thread is so far behind that there is no room.
  CommandRecord* command() { return commands_.back(); }
  void handCommand();
  void countUnsent() { unsent_.fetch_add(1, std::memory_order_relaxed); }
  CycleRecord* cycle() { return cycles_.back(); }
  void handCycle();

  /// The reader's end: of one thread.
  NewestWins<ControlSummary>& summary() { return summary_; }

 private:
  void run();
  void publishCommands();
  void publishCycles();
  void publish(const CycleRecord& record);
  void updateStatistics(const CycleRecord& record);
  void updateSummary(const CycleRecord& record);

  std::shared_ptr<const RobotModel> robot_;
  int priority_;
  RingQueue<CommandRecord> commands_;
  RingQueue<CycleRecord> cycles_;
  ActuatorCommand command_;
  ControllerState state_;
  StageStatistics stages_;
  DeadlineStatistics deadlines_;
  std::uint64_t statistics_divider_;
  std::array<std::uint64_t, 4> held_{};
  NewestWins<ControlSummary> summary_;
  std::atomic<std::uint64_t> unsent_{0};
  ros::Publisher command_publisher_, state_publisher_;
  sem_t handed_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace sinew
