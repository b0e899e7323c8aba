#include "check_advice.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

/// A cycle of one second whose stages take these shares.
CycleTiming makeTiming(double assembly, double factor, double detection, double compliance, double qp) {
  CycleTiming timing;
  const double shares[] = {assembly, factor, detection, compliance, qp, 0};
  for (std::size_t s = 0; s < timing.stages.size(); ++s) timing.stages[s].add(shares[s]);
  timing.cycle.add(1);
  return timing;
}

bool names(const std::string& words, const std::string& what) {
  return words.find(what) != std::string::npos;
}

TEST(CheckAdvice, beginsWithWhatTakesMost) {
  const auto advice = advise(RobotDescription(), makeTiming(0.2, 0.2, 0.05, 0.45, 0.1));
  ASSERT_EQ(advice.size(), 2U);
  EXPECT_TRUE(names(advice[0], "compliance takes 45 %")) << advice[0];
  EXPECT_TRUE(names(advice[1], "assembly and factor take 40 %")) << advice[1];
  EXPECT_TRUE(names(advice[1], "coarser mesh")) << advice[1];
}

TEST(CheckAdvice, namesContactsWhereThereAreAny) {
  CycleTiming timing = makeTiming(0.1, 0.04, 0.02, 0.8, 0.04);
  EXPECT_TRUE(names(advise(RobotDescription(), timing).front(), "effectors"));
  timing.contacts = 41;
  EXPECT_TRUE(names(advise(RobotDescription(), timing).front(), "41"));
  EXPECT_TRUE(names(advise(RobotDescription(), timing).front(), "max_contacts"));
}

TEST(CheckAdvice, knowsEveryStage) {
  EXPECT_TRUE(names(advise(RobotDescription(), makeTiming(0, 0.1, 0.9, 0, 0)).front(), "detection takes 90 %"));
  EXPECT_TRUE(names(advise(RobotDescription(), makeTiming(0, 0.1, 0, 0, 0.9)).front(), "max_nodes"));
}

TEST(CheckAdvice, countsNewtonSteps) {
  RobotDescription robot;
  robot.control.newton_steps = 4;
  EXPECT_TRUE(names(advise(robot, makeTiming(0.3, 0.3, 0, 0.3, 0.1)).front(), "newton_steps: 1 would spare 75 %"));
}

}  // namespace
}  // namespace sinew
