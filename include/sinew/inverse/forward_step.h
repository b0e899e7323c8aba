#pragma once

#include <cstdint>
#include <vector>

#include "sinew/inverse/condensed_robot.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/forward_problem.h"

namespace sinew {

enum class ForwardStatus { kSolved, kNotConverged, kNotFinite, kNotPositiveDefinite };

/// Moves a condensed robot by the forward problem.
class ForwardStep {
 public:
  explicit ForwardStep(const RobotModel& robot);

  /// Solves for the efforts and contact forces of a condensed robot and moves it; updates the total `effort` [N].
  ForwardStatus move(const Actuation& actuation, CondensedRobot& robot, VecX& effort, StageTimes& times);

  /// One step by `rule`; updates the total `effort` [N] and the body. `contacts` looks for contacts, null for none.
  ForwardStatus step(const Actuation& actuation, const StepRule& rule, ContactFinder* contacts, CondensedRobot& robot,
                     VecX& effort, StageTimes& times);

  /// A static step with the factor of the last `step`: a small part of its cost, for motions that are small meanwhile.
  ForwardStatus stepAgain(const Actuation& actuation, ContactFinder* contacts, CondensedRobot& robot, VecX& effort,
                          StageTimes& times);

  /// Quasi-static Newton steps until the imbalance is below `tolerance` of the load and the displacements are met to
  /// `tolerance` of the cables' lengths.
  ForwardStatus settle(const Actuation& actuation, double tolerance, int max_steps, ContactFinder* contacts,
                       CondensedRobot& robot, VecX& effort, StageTimes& times);

  auto contactForce() const { return problem_.contactForce(); }   ///< N, of the last step's contacts
  const VecX& effortMin() const { return problem_.effortMin(); }  ///< N, per actuator; -inf for a carrier
  int qpIterations() const { return problem_.iterations(); }

 private:
  struct PairForce {
    std::uint64_t key;
    double force;  // N
  };
  void recall(const ContactList& contacts);
  void remember(const ContactList& contacts);
  ForwardStatus touchAndMove(const Actuation& actuation, ContactFinder* contacts, CondensedRobot& robot, VecX& effort,
                             StageTimes& times);
  bool settled(const Actuation& actuation, double tolerance, const CondensedRobot& robot, const VecX& effort) const;

  ForwardProblem problem_;
  VecX displacement_, change_, gap_;
  VecX guess_;                          // N, contact forces to start from
  std::vector<PairForce> last_forces_;  // of the contacts that pressed, by ascending key
};

}  // namespace sinew
