#include "cycle_record.h"

#include <gtest/gtest.h>

#include "inverse/robots.h"

namespace sinew {
namespace {

class CycleRecordTest : public testing::Test {
 protected:
  std::shared_ptr<const RobotModel> robot = makeRobot(readShippedRobot("finger"));
  InverseController controller{robot};
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  CycleRecord record = makeCycleRecord(*robot, input, output);
};

TEST_F(CycleRecordTest, listsEveryMessageOnce) {
  const std::string targets = "targets", states = "actuator_state";
  record.addInput(targets, {ros::Time(1), 5});
  record.addInput(targets, {ros::Time(1), 5});
  record.addInput(states, {ros::Time(1), 5});
  ASSERT_EQ(record.input_count, 2U);
  EXPECT_EQ(record.inputs[0].topic, &targets);
  EXPECT_EQ(record.inputs[1].topic, &states);
  record.addInput(targets, {ros::Time(2), 5});
  EXPECT_EQ(record.input_count, 3U);
}

TEST_F(CycleRecordTest, neverGrows) {
  const std::string topic = "targets";
  for (std::uint32_t k = 0; k < 100; ++k) record.addInput(topic, {ros::Time(1), k});
  EXPECT_EQ(record.input_count, record.inputs.size());
}

TEST_F(CycleRecordTest, copiesOfItHaveRoomForEveryLimit) {
  const CycleRecord copy = record;
  EXPECT_GE(copy.output.limits.capacity(), output.limits.capacity());
  EXPECT_EQ(copy.output.displacement.size(), robot->actuatorCount());
  EXPECT_EQ(copy.targets.size(), 3 * robot->effectorCount());
}

TEST_F(CycleRecordTest, becomesAMessage) {
  const std::string topic = "targets";
  ControllerState message = makeStateMessage(*robot);
  record.status = ControllerState::DEGRADED;
  record.output.status = CycleStatus::kDegraded;
  record.output.overload = OverloadLevel::kSharedLinearisation;
  record.output.linearisation_age = 4;
  record.output.limits.clear();
  record.reason = describe(record.output);
  record.modelled = true;
  record.addInput(topic, {ros::Time(3), 7});
  updateStateMessage(*robot, record, message);
  EXPECT_EQ(message.overload_level, 3);
  EXPECT_EQ(message.linearisation_age, 4U);
  EXPECT_EQ(message.reason.rfind("overload", 0), 0U) << message.reason;
  ASSERT_EQ(message.inputs.size(), 1U);
  EXPECT_EQ(message.inputs[0].topic, topic);
  EXPECT_EQ(message.inputs[0].sequence, 7U);
  record.output.limits.push_back({0, LimitKind::kEffortMax, 10, 0.5});
  EXPECT_STREQ(describe(record.output), "an effort limit gave way: see limits");
}

TEST_F(CycleRecordTest, whatIsNotModelledStaysAsItWas) {
  ControllerState message = makeStateMessage(*robot);
  record.output.residual = 1;
  record.modelled = false;
  updateStateMessage(*robot, record, message);
  EXPECT_EQ(message.residual, 0);
}

}  // namespace
}  // namespace sinew
