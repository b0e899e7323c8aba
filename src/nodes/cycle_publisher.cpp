#include "cycle_publisher.h"

#include <algorithm>
#include <cmath>

#include "real_time.h"

namespace sinew {
namespace {

constexpr std::size_t kRoom = 256;         // cycles that the thread may be behind
constexpr int kQueue = 16;                 // messages that a socket may be behind
constexpr double kStatisticsPeriod = 0.1;  // s

}  // namespace

CyclePublisher::CyclePublisher(ros::NodeHandle node, const Settings& settings, std::shared_ptr<const RobotModel> robot,
                               const CycleInput& input, const CycleOutput& output)
    : robot_(std::move(robot)),
      priority_(settings.priority + 1),
      commands_(kRoom, makeCommandRecord(*robot_)),
      cycles_(kRoom, makeCycleRecord(*robot_, input, output)),
      command_(makeCommandMessage(*robot_)),
      state_(makeStateMessage(*robot_)),
      stages_(kStages, static_cast<int>(settings.rate)),
      deadlines_(1 / settings.rate, static_cast<int>(settings.rate)),
      statistics_divider_(static_cast<std::uint64_t>(std::max(1.0, std::round(settings.rate * kStatisticsPeriod)))),
      command_publisher_(node.advertise<ActuatorCommand>("actuator_command", kQueue)),
      state_publisher_(node.advertise<ControllerState>("controller_state", kQueue)) {
  sem_init(&handed_, 0, 0);
  thread_ = std::thread(&CyclePublisher::run, this);
}

CyclePublisher::~CyclePublisher() {
  stop_ = true;
  sem_post(&handed_);
  thread_.join();
  sem_destroy(&handed_);
}

void CyclePublisher::handCommand() {
  commands_.push();
  sem_post(&handed_);
}

void CyclePublisher::handCycle() {
  cycles_.push();
  sem_post(&handed_);
}

void CyclePublisher::run() {
  nameThread("publisher");
  raisePriority(priority_);
  while (!stop_) {
    if (sem_wait(&handed_) != 0) continue;
    publishCommands();
    publishCycles();
  }
}

void CyclePublisher::publishCommands() {
  for (; const CommandRecord* record = commands_.front(); commands_.pop()) {
    command_.header.stamp = ros::Time::now();
    updateCommandMessage(*record, command_);
    command_publisher_.publish(command_);
  }
}

void CyclePublisher::publishCycles() {
  for (; const CycleRecord* record = cycles_.front(); cycles_.pop()) {
    updateStatistics(*record);
    publish(*record);
    updateSummary(*record);
    publishCommands();
  }
}

void CyclePublisher::updateStatistics(const CycleRecord& record) {
  stages_.add(record.durations.data());
  deadlines_.add(record.answered, record.skipped, record.output.overload);
  if (record.status == ControllerState::HELD) ++held_[static_cast<std::size_t>(record.output.reason)];
  if (record.cycle % statistics_divider_ != 0) return;
  stages_.update();
  deadlines_.update();
}

void CyclePublisher::publish(const CycleRecord& record) {
  state_.header.stamp = ros::Time::now();
  state_.deadline_misses = deadlines_.misses();
  updateStateMessage(*robot_, record, state_);
  updateStageMessages(stages_, state_.stages);
  state_publisher_.publish(state_);
}

void CyclePublisher::updateSummary(const CycleRecord& record) {
  ControlSummary& summary = summary_.back();
  summary.status = record.status;
  summary.reason = record.reason;
  summary.cycle = record.cycle;
  summary.held = held_;
  summary.median = stages_.median(kStages - 1);
  summary.maximum = stages_.maximum(kStages - 1);
  summary.misses = deadlines_.misses();
  summary.worst_answer = deadlines_.worst();
  summary.recent_answer = deadlines_.recent();
  summary.level = record.output.overload;
  summary.levels = deadlines_.levels();
  summary.unsent = unsent_.load(std::memory_order_relaxed);
  summary_.publish();
}

}  // namespace sinew
