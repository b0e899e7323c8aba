#pragma once

#include <vector>

#include "sinew/common/types.h"
#include "sinew/inverse/condensed_robot.h"
#include "sinew/inverse/contact_finder.h"
#include "sinew/inverse/contact_piece.h"
#include "sinew/inverse/contact_search.h"
#include "sinew/inverse/cycle.h"
#include "sinew/inverse/inverse_problem.h"
#include "sinew/inverse/step_damping.h"

namespace sinew {

/// What a linearised robot is to do in a cycle: which contacts press, and by how much each effort changes. Holds what
/// one cycle hands to the next: the pressing contacts, the damping, warm starts. No allocation after construction.
class CyclePlan {
 public:
  explicit CyclePlan(const RobotModel& robot);

  /// Plans for a condensed robot whose contacts are those of `finder`; `effort` [N] is the present total. Adds to the
  /// output what the search and the programmes report.
  HoldReason make(const CondensedRobot& robot, const ContactFinder& finder, const CycleInput& input,
                  const CycleLimits& limits, const VecX& effort, CycleOutput& output);

  const VecX& effortChange() const { return result_.effort_change; }        ///< N
  const VecX& effortViolation() const { return result_.effort_violation; }  ///< N
  /// Whether the effectors that are to hold do, in the linear problem.
  bool holds() const { return goal_.held == 0 || (goal_.firm && result_.held); }
  const ContactSearch& search() const { return search_; }
  auto contactForce() const { return contact_force_.head(contacts_); }              ///< N
  auto contactGap() const { return contact_gap_.head(contacts_); }                  ///< m
  auto actuatorMotion() const { return row_motion_.head(robot_.actuatorCount()); }  ///< m, the linear problem's

  /// `scale` <= 1 of the planned motion was made.
  void recordStep(double scale);
  /// The model stands elsewhere from now on.
  void forget();

 private:
  void gatherRows(const CondensedRobot& robot, const CycleInput& input, bool held);
  double gatherGoal(const CondensedRobot& robot, const CycleInput& input, CycleOutput& output);
  bool searchPiece(const CondensedRobot& robot, const ContactFinder& finder, const CycleInput& input,
                   const CycleLimits& limits, const VecX& effort, CycleOutput& output);
  void updateDamping(const CondensedRobot& robot, const ContactFinder& finder);
  double calcDamping(double goal_scale) const;
  void gatherProblem(const CondensedRobot& robot, const VecX& effort, double goal_scale);
  void allowSearched();
  bool solveProblem(const CycleLimits& limits, CycleOutput& output);
  void calcMotion(const CondensedRobot& robot);

  const RobotModel& robot_;
  EffectorGoal goal_;
  ContactSearch search_;
  ContactPiece piece_;
  std::vector<char> none_pressing_;
  InverseProblem problem_;
  InverseProblemData data_;
  InverseProblemResult result_;
  StepDamping damping_;
  int contacts_ = 0;
  bool pressed_ = false;              // some contact did, in the last cycle
  VecX contact_force_, contact_gap_;  // N, m
  double missed_ = 0;                 // m, of the goal, after the step
  VecX last_motion_;                  // m, of the rows before the contacts
  VecX gap_shift_;                    // m, of contacts, by the moving of obstacles
  VecX pushed_, drift_;               // m, of the rows before the contacts: by that moving, and the rest
  VecX row_motion_;                   // m, of every row
};

}  // namespace sinew
