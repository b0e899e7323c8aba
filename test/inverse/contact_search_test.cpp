#include "sinew/inverse/contact_search.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "inverse/contact_robot.h"

namespace sinew {
namespace {

constexpr int kGoals = 100;
constexpr double kNoise = 3e-5;                                         // m, greatest of a goal along each axis
const Vec3 kEasilyWithout(0, 0, -0.005), kEasilyPushing(0, 0, -0.012);  // m, motions of the tip

/// A bar without weight, short cables along its lower half, and a post above it beyond their anchors: pulled from below
/// its tip sinks; pulled hard from above it tilts on the post, and sinks as well.
RobotDescription makeTwoWays() {
  RobotDescription robot = makeContactDescription({makeCylinder(0.01, Vec3(0.12, 0.01, 0.0315))});
  robot.gravity.setZero();
  robot.effectors[0].point = Vec3(0.2, 0.01, 0.01);
  for (CableDescription& cable : robot.cables) {
    const Vec3 edge(0, cable.pull_point.y(), cable.pull_point.z());
    cable.via_points = {edge + Vec3(0.02, 0, 0), edge + Vec3(0.05, 0, 0)};
    cable.displacement = {-0.02, 0.02, 0.2};
  }
  return robot;
}

/// One linear problem of such a robot, its goal given as a motion of the tip.
class TwoWays {
 public:
  explicit TwoWays(const RobotDescription& description)
      : robot_(std::make_shared<const RobotModel>(description, makeBarMesh(Vec3(0.2, 0.02, 0.02), 16, 2, 2))),
        condensed_(robot_),
        finder_(*robot_),
        search_(*robot_, 3),
        goal_(3),
        limits_(4),
        effort_(VecX::Zero(4)) {
    condensed_.linearise(effort_, StepRule(), times_);
    EXPECT_TRUE(condensed_.factorise(times_));
    finder_.find(condensed_.body().positions(), times_);
    condensed_.addContacts(finder_);
    condensed_.condense(times_);
    for (int k = 0; k < 3; ++k) goal_.rows.push_back(4 + k);
    limits_.displacement_min.setConstant(-1);
    limits_.displacement_max.setConstant(1);
    limits_.effort_min.setZero();
    limits_.effort_max << 0.1, 0.1, 10, 10;
  }

  QpccStatus solve(const Vec3& motion) {
    goal_.error = -motion;
    return search_.solve(condensed_, finder_.list(), goal_, limits_, effort_, 0);
  }
  const QpccSolution& solution() const { return search_.solution(); }
  const QpccProblem& problem() const { return search_.problem(); }
  VecX force() const { return solution().z.head(condensed_.contacts()); }
  VecX calcDisplacement() const {
    const QpccProblem& p = problem();
    return p.A_a.topRows(4) * solution().x + p.A_c.topLeftCorner(4, p.size.contacts) * force() + p.a.head(4);
  }
  Vec3 calcMotion() const {
    const int contacts = condensed_.contacts();
    const MatX W = condensed_.compliance().middleRows(4, 3);
    return W.leftCols(4) * solution().x + W.rightCols(contacts) * force();
  }
  /// The leading rows are equalities.
  void hold(int rows) { goal_.held = rows; }
  bool pushesThePost() const { return solution().x.tail(2).sum() > solution().x.head(2).sum(); }
  void forget() { search_.forget(); }

  /// Whether the post is pushed by whoever knows no earlier answer.
  bool pushesThePostAt(const Vec3& motion) {
    forget();
    EXPECT_EQ(solve(motion), QpccStatus::kSolved);
    return pushesThePost();
  }

  /// Between two motions that ask for different ways, one that both answer alike.
  Vec3 findDivide(Vec3 without, Vec3 with) {
    EXPECT_FALSE(pushesThePostAt(without));
    EXPECT_TRUE(pushesThePostAt(with));
    for (int k = 0; k < 40; ++k) {
      const Vec3 middle = 0.5 * (without + with);
      (pushesThePostAt(middle) ? with : without) = middle;
    }
    return with;
  }

  /// How often noise turns the way, and how often a better one is declined.
  void follow(const Vec3& motion, int& turns, int& declined) {
    std::mt19937 random(1);
    std::uniform_real_distribution<double> uniform(-kNoise, kNoise);
    forget();
    turns = declined = 0;
    bool pushed = false;
    for (int k = 0; k < kGoals; ++k) {
      const Vec3 noise(uniform(random), uniform(random), uniform(random));
      EXPECT_EQ(solve(motion + noise), QpccStatus::kSolved);
      turns += k > 0 && pushesThePost() != pushed;
      pushed = pushesThePost();
      declined += solution().declined_better;
    }
  }

 private:
  std::shared_ptr<const RobotModel> robot_;
  CondensedRobot condensed_;
  ContactFinder finder_;
  ContactSearch search_;
  EffectorGoal goal_;
  CycleLimits limits_;
  VecX effort_;
  StageTimes times_;
};

TEST(ContactSearch, noiseDoesNotTurnItsWay) {
  RobotDescription description = makeTwoWays();
  TwoWays steady(description);
  const Vec3 divide = steady.findDivide(kEasilyWithout, kEasilyPushing);
  int turns = 0, declined = 0;
  steady.follow(divide, turns, declined);
  EXPECT_LE(turns, 1) << "only the first answer has no other before it";
  EXPECT_GE(declined, kGoals / 4) << "on the side of the other way";

  description.control.switching_margin = 0;
  TwoWays fickle(description);
  fickle.follow(divide, turns, declined);
  EXPECT_GE(turns, kGoals / 4);
  EXPECT_EQ(declined, 0);
}

TEST(ContactSearch, leapsForMoreThanTheMargin) {
  TwoWays ways(makeTwoWays());
  EXPECT_FALSE(ways.pushesThePostAt(kEasilyWithout));
  EXPECT_EQ(ways.solve(kEasilyPushing), QpccStatus::kSolved);
  EXPECT_TRUE(ways.pushesThePost());
  EXPECT_FALSE(ways.solution().declined_better);
  EXPECT_GT(ways.solution().decomposition_objective, 1.05 * ways.solution().objective);
}

TEST(ContactSearch, leapsNoFartherThanItsReach) {
  RobotDescription description = makeTwoWays();
  TwoWays free(description);
  ASSERT_TRUE(free.pushesThePostAt(kEasilyPushing));
  const double way = free.calcDisplacement().cwiseAbs().maxCoeff();
  for (const double share : {0.9, 1.1}) {
    description.control.switching_reach = share * way;
    TwoWays ways(description);
    ASSERT_FALSE(ways.pushesThePostAt(kEasilyWithout));
    ASSERT_EQ(ways.solve(kEasilyPushing), QpccStatus::kSolved);
    EXPECT_EQ(ways.pushesThePost(), share > 1);
    EXPECT_EQ(ways.solution().declined_better, share < 1);
    if (share < 1) {
      EXPECT_LT(ways.solution().declined_objective, ways.solution().objective);
    }
  }
}

TEST(ContactSearch, endsInTime) {
  RobotDescription description = makeTwoWays();
  description.control.search_time = 1e-12;  // less than a tick of the clock: over when it begins
  TwoWays ways(description);
  for (int k = 0; k < 3; ++k) {
    ASSERT_EQ(ways.solve(kEasilyPushing), QpccStatus::kSolved);
    EXPECT_TRUE(ways.solution().deadline_ended);
    EXPECT_FALSE(ways.solution().proved_global);
  }
  TwoWays patient(makeTwoWays());
  ASSERT_EQ(patient.solve(kEasilyPushing), QpccStatus::kSolved);
  EXPECT_FALSE(patient.solution().deadline_ended);
  EXPECT_TRUE(patient.solution().proved_global);
  EXPECT_LE(patient.solution().objective, ways.solution().objective);
}

TEST(ContactSearch, holdsRowsThatAreToHold) {
  TwoWays ways(makeTwoWays());
  ways.hold(1);
  ASSERT_EQ(ways.solve(Vec3(-0.001, 0, -0.002)), QpccStatus::kSolved);
  EXPECT_NEAR(ways.calcMotion().x(), -0.001, 1e-12);
  EXPECT_GT(std::abs(ways.calcMotion().z() + 0.002), 1e-6) << "the others get what is left";
  EXPECT_NE(ways.solve(Vec3(0.001, 0, -0.002)), QpccStatus::kSolved) << "cables do not push";
}

}  // namespace
}  // namespace sinew
