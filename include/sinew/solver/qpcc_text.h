#pragma once

#include <istream>
#include <ostream>
#include <string>

#include "sinew/solver/qpcc_problem.h"

namespace sinew {

/// Writes a problem as text that `readQpcc` gives back to the last bit: a line "qpcc n_a n_r n_e n_c", then a line for
/// each block, its name first, its entries row after row, in SI units; "end". Several may follow each other.
void writeQpcc(std::ostream& out, const QpccProblem& problem);

/// Whether another problem follows.
bool hasQpcc(std::istream& in);

/// Throws ConfigError, naming `source`, if the text is not of that form.
QpccProblem readQpcc(std::istream& in, const std::string& source);

}  // namespace sinew
