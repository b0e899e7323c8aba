#include "sinew/inverse/step_damping.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

constexpr double kStep = 1e-3;  // m

double dampingAfter(int bad_steps, int good_steps) {
  StepDamping damping;
  for (int k = 0; k < bad_steps + good_steps; ++k) {
    damping.recordStep(kStep);
    damping.update(k < bad_steps ? 0.8 * kStep : 0.01 * kStep, 0);
  }
  return damping.value();
}

TEST(StepDamping, StartsAndStaysWithoutDampingWhileStepsComeTrue) {
  EXPECT_EQ(StepDamping().value(), 0);
  EXPECT_EQ(dampingAfter(0, 50), 0);
}

TEST(StepDamping, RisesWithEveryStepThatMisleadsUpToABound) {
  double before = 0;
  for (int steps = 1; steps < 8; ++steps) {
    EXPECT_GT(dampingAfter(steps, 0), before);
    before = dampingAfter(steps, 0);
  }
  EXPECT_EQ(dampingAfter(100, 0), dampingAfter(101, 0));
  EXPECT_LT(dampingAfter(100, 0), 100);
}

TEST(StepDamping, FallsAndVanishesAfterwards) {
  double before = dampingAfter(100, 0);
  for (int steps = 1; steps < 10; ++steps) {
    EXPECT_LT(dampingAfter(100, steps), before);
    before = dampingAfter(100, steps);
  }
  EXPECT_EQ(dampingAfter(100, 60), 0);
}

TEST(StepDamping, RisesWhenStepsGoToAndFro) {
  StepDamping damping;
  damping.recordStep(kStep, true);
  damping.update(0, 0);
  EXPECT_GT(damping.value(), 0);
  const double risen = damping.value();
  damping.recordStep(kStep);
  damping.update(0, 0);
  EXPECT_LT(damping.value(), risen);
}

TEST(StepDamping, ExpectsNoMoreOfAPushThanOfAStep) {
  StepDamping damping;
  damping.recordStep(0.01 * kStep);
  damping.update(0.3 * kStep, kStep);
  EXPECT_EQ(damping.value(), 0);
  damping.update(0.6 * kStep, kStep);
  EXPECT_GT(damping.value(), 0);
}

TEST(StepDamping, LearnsNothingFromAStepTooShortToMatter) {
  StepDamping damping;
  damping.recordStep(1e-9);
  damping.update(1, 0);
  EXPECT_EQ(damping.value(), 0);
}

TEST(StepDamping, ResetForgetsTheStepToo) {
  StepDamping damping;
  damping.recordStep(kStep);
  damping.update(kStep, 0);
  ASSERT_GT(damping.value(), 0);
  damping.reset();
  EXPECT_EQ(damping.value(), 0);
  damping.update(kStep, 0);
  EXPECT_EQ(damping.value(), 0);
}

}  // namespace
}  // namespace sinew
