#include "cycle_record.h"

namespace sinew {

void CycleRecord::addInput(const std::string& topic, const MessageStamp& source) {
  for (std::size_t i = 0; i < input_count; ++i) {
    const InputReference& other = inputs[i];
    if (other.topic == &topic && other.source.stamp == source.stamp && other.source.sequence == source.sequence) return;
  }
  if (input_count < inputs.size()) inputs[input_count++] = {&topic, source};
}

CommandRecord makeCommandRecord(const RobotModel& robot) {
  CommandRecord record;
  record.displacement = VecX::Zero(robot.actuatorCount());
  record.effort = VecX::Zero(robot.actuatorCount());
  return record;
}

// A copy keeps no more room than it has entries.
CycleRecord makeCycleRecord(const RobotModel& robot, const CycleInput& input, const CycleOutput& output) {
  CycleRecord record;
  record.targets = input.targets;
  record.targeted = input.targeted;
  record.output = output;
  record.output.limits.resize(output.limits.capacity());
  record.inputs.resize(input.targeted.size() + robot.obstacles().size() + 1);
  return record;
}

}  // namespace sinew
