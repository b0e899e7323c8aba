#pragma once

#include <random>
#include <string>
#include <vector>

#include "sinew/solver/qpcc_problem.h"

namespace sinew {

/// Answers of a QpccSolver held against three others: the plain full formulation, the reduced one, and the enumeration
/// of all pieces by either.
class QpccTally {
 public:
  /// `random` draws pieces to compare the two formulations in.
  void add(const QpccProblem& problem, const QpccSolution& solution, std::mt19937& random);

  /// What every problem set has to satisfy, as figures of the check, `prefix` before their names.
  void check(const std::string& prefix) const;

  int problems() const { return problems_; }
  int solved() const { return solved_; }
  int givenWay() const { return given_way_; }
  int infeasible() const { return infeasible_; }
  double calcTrapped()
      const;  ///< %, solved problems where the decomposition alone ends more than 1 % above the optimum

 private:
  void comparePieces(const QpccProblem& problem, const std::vector<char>& answer, std::mt19937& random);
  void compareEnumerations(const QpccProblem& problem, double reduced, double full);
  void checkSolved(const QpccProblem& problem, const QpccSolution& solution, double optimum);
  void checkViolated(const QpccProblem& problem, const QpccSolution& solution);

  int problems_ = 0, solved_ = 0, found_ = 0, proved_ = 0, wrong_proofs_ = 0, worse_than_decomposition_ = 0;
  int trapped_ = 0, given_way_ = 0, infeasible_ = 0, wrong_status_ = 0, least_violation_ = 0, violations_checked_ = 0;
  int pieces_ = 0, pieces_disagreeing_ = 0, enumerations_disagreeing_ = 0;
  double piece_difference_ = 0, full_difference_ = 0, excess_ = 0, energy_ = 0;
  double gap_ = 0, force_ = 0, complementarity_ = 0, limits_ = 0;
};

}  // namespace sinew
