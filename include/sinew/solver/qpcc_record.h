#pragma once

#include <ostream>
#include <string>
#include <vector>

#include "sinew/solver/qpcc_problem.h"
#include "sinew/solver/qpcc_solver.h"

namespace sinew {

/// The QPCC of one control cycle with all that went into its answer.
struct QpccRecord {
  int cycle = 0;
  double time = 0;                 ///< s
  std::vector<std::string> names;  ///< of the unknowns
  const QpccProblem& problem;
  const QpccGuess& guess;
  const QpccSolution& solution;
  const std::vector<QpccVisit>& visits;
};

/// Writes a record as text, numbers to the last bit, SI units: a line "record CYCLE TIME NAME ...", the problem as by
/// `writeQpcc`, then a line each
///   guess VALID MARGIN OFFSET         and on lines of their own x, active, row, reach
///   solution STATUS OBJECTIVE PROVED DECLINED, the same with x, z, active
///   visit DESCENT OBJECTIVE x ...     for each visited point
///   done
/// Several may follow each other.
void writeQpccRecord(std::ostream& out, const QpccRecord& record);

}  // namespace sinew
