// What a controller leaves out under overload, and what it keeps: limits, the way to the target, contacts.

#include <gtest/gtest.h>

#include <random>

#include "check_line.h"
#include "inverse/contact_robot.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr OverloadLevel kShared = OverloadLevel::kSharedLinearisation;

/// A controller whose linearisation, when it is shared, is renewed every so many cycles, begun `delay` cycles earlier.
class BarRun {
 public:
  explicit BarRun(const RobotDescription& description, OverloadLevel level, int every = 2, int delay = 1)
      : robot(makeBarRobot(description)), controller(robot), every_(every), delay_(delay) {
    controller.makeSpare();
    controller.resynchronise(VecX::Zero(robot->actuatorCount()));
    input.overload = level;
    input.targeted.assign(input.targeted.size(), true);
    for (int e = 0; e < robot->effectorCount(); ++e) {
      input.targets.segment<3>(3 * e) = robot->description().effectors[static_cast<std::size_t>(e)].point;
    }
    for (const Obstacle& obstacle : robot->obstacles()) input.obstacles.push_back({obstacle.pose, true});
  }

  CycleStatus step() {
    const bool shares = input.overload == kShared;
    if (shares && cycle_ % every_ == delay_ % every_) controller.endRenewal();
    const CycleStatus status = controller.step(input, output);
    if (!shares) {
      controller.prepare(output);
    } else if (cycle_ % every_ == 0) {
      controller.beginRenewal();
      controller.renew(renewal_);
    }
    ++cycle_;
    return status;
  }

  void step(int cycles) {
    for (int k = 0; k < cycles; ++k) ASSERT_NE(step(), CycleStatus::kHeld) << "cycle " << k;
  }

 private:
  StageTimes renewal_;

 public:
  std::shared_ptr<const RobotModel> robot;
  InverseController controller;
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();

 private:
  int every_, delay_, cycle_ = 0;
};

RobotDescription makePosted() {
  return makeContactDescription({makeCylinder(0.01, Vec3(0.07, 0.01, -0.0115))});
}

const Vec3 kWay(0, 0.002, 0.003);  // m, of the tip of the bar

TEST(Overload, aNewtonStepIsAllThatIsLeftOfMany) {
  RobotDescription description = makeBarDescription();
  description.control.newton_steps = 4;
  BarRun whole(description, OverloadLevel::kNone), hurried(description, OverloadLevel::kOneNewtonStep);
  whole.step(1);
  hurried.step(1);
  EXPECT_EQ(whole.output.newton_steps, 4);
  EXPECT_EQ(hurried.output.newton_steps, 1);
}

TEST(Overload, isSaidInTheStatus) {
  for (const OverloadLevel level : {OverloadLevel::kOneNewtonStep, OverloadLevel::kNoExploration, kShared}) {
    BarRun run(makeBarDescription(), level);
    EXPECT_EQ(run.step(), CycleStatus::kDegraded);
    EXPECT_EQ(run.output.overload, level);
  }
  BarRun run(makeBarDescription(), OverloadLevel::kNone);
  EXPECT_EQ(run.step(), CycleStatus::kSolved);
}

TEST(Overload, nothingIsExplored) {
  BarRun whole(makePosted(), OverloadLevel::kNone), hurried(makePosted(), OverloadLevel::kNoExploration);
  int explored = 0;
  for (int k = 0; k < 60; ++k) {
    for (BarRun* run : {&whole, &hurried}) {
      run->input.targets.head<3>() += Vec3(0, 0, -1e-4);
      ASSERT_NE(run->step(), CycleStatus::kHeld);
    }
    explored += whole.output.contacts.nodes;
    ASSERT_EQ(hurried.output.contacts.nodes, 0);
    ASSERT_FALSE(hurried.output.contacts.count > 0 && hurried.output.contacts.proved_global);
    ASSERT_LE(hurried.output.contacts.pieces, std::max(whole.output.contacts.pieces, 8));
  }
  EXPECT_GT(explored, 0);
}

// Without moving targets, levels lead to one and the same place: that of the whole problem.
TEST(Overload, everyLevelSettlesAtTheSamePlace) {
  for (const bool posted : {false, true}) {
    const RobotDescription description = posted ? makePosted() : makeBarDescription();
    BarRun whole(description, OverloadLevel::kNone);
    whole.input.targets.head<3>() += posted ? Vec3(0, 0, -0.004) : kWay;
    whole.step(600);
    for (const OverloadLevel level : {OverloadLevel::kOneNewtonStep, OverloadLevel::kNoExploration, kShared}) {
      BarRun run(description, level, 2, 1);
      run.input.targets = whole.input.targets;
      run.step(600);
      const double difference = (run.output.displacement - whole.output.displacement).cwiseAbs().maxCoeff();
      EXPECT_LT(difference, 1e-8) << "posted " << posted << " level " << static_cast<int>(level);
    }
  }
}

// The first answer from a linearisation that was renewed where the robot stands is the ordinary cycle's.
TEST(Overload, aFreshLinearisationAnswersLikeAnOrdinaryCycle) {
  BarRun ordinary(makeBarDescription(), OverloadLevel::kNoExploration), shared(makeBarDescription(), kShared, 1, 0);
  for (int k = 0; k < 40; ++k) {
    for (BarRun* run : {&ordinary, &shared}) {
      run->input.targets.head<3>() += 0.02 * kWay;
      ASSERT_NE(run->step(), CycleStatus::kHeld);
    }
    ASSERT_LT((ordinary.output.displacement - shared.output.displacement).cwiseAbs().maxCoeff(), 1e-12) << k;
    ASSERT_FALSE(shared.output.repeats);
  }
}

// Asked again with nothing changed, the same linear problem has the same answer.
TEST(Overload, aRepeatedLinearisationGivesTheSameAnswer) {
  RobotDescription description = withoutRates(makeBarDescription());
  BarRun run(description, kShared, 1000, 999);
  run.input.targets.head<3>() += kWay;
  run.step(1);
  EXPECT_FALSE(run.output.repeats);
  const VecX displacement = run.output.displacement, effectors = run.output.effectors;
  for (int k = 1; k < 5; ++k) {
    run.step(1);
    EXPECT_TRUE(run.output.repeats);
    EXPECT_EQ(run.output.linearisation_age, k);
    EXPECT_LT((run.output.displacement - displacement).cwiseAbs().maxCoeff(), 1e-10);
    EXPECT_LT((run.output.effectors - effectors).cwiseAbs().maxCoeff(), 1e-10);
  }
}

/// m, of the robot settled at a command, from the target: y and z.
double calcTrueError(const BarRun& run) {
  ForwardSimulator forward(run.robot);
  Actuation actuation = forward.makeActuation();
  actuation.value = run.output.displacement;
  EXPECT_EQ(forward.settle(actuation), ForwardStatus::kSolved);
  return (forward.effectors() - run.input.targets).segment<2>(1).norm();
}

/// Largest true error [m] of a tip that is led round an ellipse, once it is on it.
double calcWorstError(BarRun& run, double period, int cycles) {
  const Vec3 centre = run.input.targets.head<3>();
  run.input.period = period;
  double worst = 0;
  for (int k = 0; k < cycles; ++k) {
    const double angle = 6.283 * k * period / 2;
    run.input.targets.head<3>() = centre + Vec3(0, 0.003 * std::sin(angle), 0.002 * (1 - std::cos(angle)));
    EXPECT_NE(run.step(), CycleStatus::kHeld);
    if (k > cycles / 10 && k % 101 == 0) worst = std::max(worst, calcTrueError(run));
  }
  return worst;
}

TEST(Overload, sharedLinearisationsStillFollow) {
  RobotDescription description = makeBarDescription();
  description.effectors[0].axes = {{false, true, true}};
  for (CableDescription& cable : description.cables) cable.tension.min = 0.1;
  for (const int every : {2, 4, 8}) {
    BarRun run(description, kShared, every, 1);
    checkFigure("overload.error_every_" + std::to_string(every), 1e3 * calcWorstError(run, 0.001, 3000), "<=", 0.1,
                "mm");
  }
}

TEST(Overload, targetsBetweenTwoRenewalsCount) {
  BarRun run(withoutRates(makeBarDescription()), kShared, 1000, 999);
  run.step(2);
  const VecX before = run.output.displacement;
  run.input.targets.head<3>() += kWay;
  run.step(1);
  EXPECT_TRUE(run.output.repeats);
  EXPECT_GT((run.output.displacement - before).cwiseAbs().maxCoeff(), 1e-4);
}

TEST(Overload, limitsAreKeptWhileLinearisationsAreShared) {
  std::mt19937 random(5);
  std::uniform_real_distribution<double> uniform(-1, 1);
  const RobotDescription description = makePosted();
  BarRun run(description, kShared, 4, 3);
  const Vec3 centre = run.input.targets.head<3>();
  VecX before = run.output.displacement;
  for (int k = 0; k < 600; ++k) {
    if (k % 15 == 0) {
      run.input.targets.head<3>() = centre + 0.03 * Vec3(uniform(random), uniform(random), uniform(random));
    }
    run.step();
    for (int i = 0; i < before.size(); ++i) {
      const Limits& range = run.robot->actuators()[static_cast<std::size_t>(i)].displacement;
      ASSERT_GE(run.output.displacement[i], range.min - 1e-12);
      ASSERT_LE(run.output.displacement[i], range.max + 1e-12);
      ASSERT_LE(std::abs(run.output.displacement[i] - before[i]), range.rate * run.input.period + 1e-12);
    }
    before = run.output.displacement;
  }
}

// An obstacle that comes nearer between two renewals is known to do so.
TEST(Overload, gapsFollowTheirObstacleBetweenRenewals) {
  BarRun run(makePosted(), kShared, 1000, 999);
  run.step(1);
  ASSERT_GT(run.output.contacts.count, 0);
  const double gap = run.controller.contacts().row(0).gap;
  const Vec3 normal = run.controller.contacts().row(0).normal;
  const Vec3 way(0, 0, 2e-4);
  double shifted = gap;
  for (int k = 0; k < 3; ++k) {
    run.input.obstacles[0].pose = Eigen::Translation3d(way) * run.input.obstacles[0].pose;
    run.step(1);
    shifted -= normal.dot(way);
    ASSERT_TRUE(run.output.repeats);
    const double force = run.output.contacts.force[0];
    if (force > 0) {
      EXPECT_NEAR(run.output.contacts.gap[0], 0, 1e-9);
    } else {
      EXPECT_GE(run.output.contacts.gap[0], -1e-9);
    }
  }
  EXPECT_LT(shifted, gap);
}

TEST(Overload, withoutTargetsThereIsSharingToo) {
  BarRun run(makeBarDescription(), kShared, 3, 2);
  run.input.targeted.assign(1, false);
  const VecX pulled = VecX::Constant(run.robot->actuatorCount(), 0.002);
  for (int k = 0; k <= 300; ++k) {
    run.input.applied = pulled * std::min(1.0, k / 200.0);
    ASSERT_EQ(run.step(), CycleStatus::kDegraded);
    ASSERT_EQ(run.output.displacement, run.input.applied);
  }
  ForwardSimulator forward(run.robot);
  Actuation actuation = forward.makeActuation();
  actuation.value = pulled;
  ASSERT_EQ(forward.settle(actuation), ForwardStatus::kSolved);
  EXPECT_LT((forward.effectors() - run.output.effectors).cwiseAbs().maxCoeff(), 1e-8);
}

TEST(Overload, aDynamicBodyIsShownByItsPlanMeanwhile) {
  RobotDescription description = makeBarDescription();
  description.control.model = MotionModel::kDynamic;
  description.damping_mass = 20;
  BarRun run(description, kShared);
  run.input.targets.head<3>() += kWay;
  run.step(200);
  const VecX planned = run.output.effectors;
  run.input.overload = OverloadLevel::kNone;
  run.step(1);
  EXPECT_LT((run.output.effectors - planned).cwiseAbs().maxCoeff(), 1e-4) << "it does not leap when its time comes";
  run.step(400);
  EXPECT_LT((run.output.effectors - planned).cwiseAbs().maxCoeff(), 1e-5);
}

// Up and down at random, with a renewal under way or not: the way to the target is kept.
TEST(Overload, levelsMayChangeAtAnyTime) {
  std::mt19937 random(11);
  std::uniform_int_distribution<int> level(0, 3);
  BarRun run(makePosted(), OverloadLevel::kNone, 3, 2);
  const Vec3 start = run.input.targets.head<3>();
  for (int k = 0; k < 400; ++k) {
    run.input.overload = static_cast<OverloadLevel>(level(random));
    run.input.targets.head<3>() = start + std::min(1.0, k / 200.0) * Vec3(0, 0.001, -0.004);
    ASSERT_NE(run.step(), CycleStatus::kHeld) << "cycle " << k;
  }
  BarRun whole(makePosted(), OverloadLevel::kNone);
  whole.input.targets = run.input.targets;
  whole.step(600);
  run.input.overload = OverloadLevel::kNone;
  run.step(600);
  EXPECT_LT((run.output.displacement - whole.output.displacement).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(Overload, resettingDropsARenewal) {
  BarRun run(makeBarDescription(), kShared, 1000, 999);
  run.input.targets.head<3>() += kWay;
  run.step(3);
  run.controller.beginRenewal();
  StageTimes times;
  run.controller.renew(times);
  run.controller.reset();
  run.controller.endRenewal();
  run.input.targets.head<3>() -= kWay;
  run.step(1);
  EXPECT_FALSE(run.output.repeats);
  BarRun fresh(makeBarDescription(), kShared);
  fresh.controller.reset();
  fresh.step(1);
  EXPECT_LT((run.output.displacement - fresh.output.displacement).cwiseAbs().maxCoeff(), 1e-12);
}

}  // namespace
}  // namespace sinew
