#pragma once

#include <cstdint>
#include <vector>

#include "sinew/contact/contact_list.h"
#include "sinew/inverse/condensed_robot.h"
#include "sinew/inverse/inverse_problem.h"
#include "sinew/solver/qpcc_solver.h"

namespace sinew {

/// The targeted effectors of a cycle.
struct EffectorGoal {
  explicit EffectorGoal(int max_rows) : error(max_rows) { rows.reserve(static_cast<std::size_t>(max_rows)); }
  std::vector<int> rows;  ///< of the condensed robot, those that are to hold first
  VecX error;             ///< weighted error with efforts unchanged and contacts let go, one per row [m]
  int held = 0;           ///< how many are to hold
  bool firm = true;       ///< these are equalities; otherwise only the strongest of the wishes

  int equalities() const { return firm ? held : 0; }
  double weightOf(int k) const { return k < held && !firm ? kHoldWeight : 1; }
};

/// What a search may take, besides what the robot's description allows.
struct SearchAllowance {
  bool explores = true;  ///< false: only the descent from the last answer
  double time = 0;       ///< s; 0 for no bound
};

/// Which contacts are to press: the inverse problem with contacts (thesis 4.3.2),
///   min 1/2 |W_ea d + W_ec f + error|^2   within the limits of the cycle,   0 <= f  _|_  W_ca d + W_cc f + gap >= 0,
/// lightly regularised by the energy of the efforts, searched globally while its budget lasts, from where the last
/// cycle left it; what lies far from there has to be worth the leap. Rows that hold are equalities. The limits on
/// efforts give way where nothing else is possible. No allocation after construction.
class ContactSearch {
 public:
  ContactSearch(const RobotModel& robot, int max_effector_rows);

  QpccStatus solve(const CondensedRobot& robot, const ContactList& contacts, const EffectorGoal& goal,
                   const CycleLimits& limits, const VecX& effort, double damping,
                   const SearchAllowance& allowance = SearchAllowance());
  const QpccSolution& solution() const { return solution_; }
  const QpccProblem& problem() const { return problem_; }
  const QpccGuess& guess() const { return guess_; }  ///< that the last search started from

  /// The next cycle starts from nothing.
  void forget();

 private:
  void gather(const CondensedRobot& robot, const EffectorGoal& goal, const CycleLimits& limits, const VecX& effort,
              double damping);
  void recall(const CondensedRobot& robot, const ContactList& contacts, const VecX& effort);
  QpccBudget makeBudget(const SearchAllowance& allowance) const;
  void remember(const ContactList& contacts);

  const RobotModel& robot_;
  QpccProblem problem_;
  QpccGuess guess_;
  QpccSolution solution_;
  QpccSolver solver_;
  std::vector<std::uint64_t> pressing_keys_;  // of the last cycle, ascending
  bool known_ = false;
};

}  // namespace sinew
