#include "sinew/solver/qpcc_record.h"

#include <limits>

#include "sinew/solver/qpcc_text.h"

namespace sinew {

namespace {

constexpr int kDigits = std::numeric_limits<double>::max_digits10;

template <typename Values>
void writeLine(std::ostream& out, const char* name, const Values& values, int count) {
  out << name;
  for (int i = 0; i < count; ++i) out << ' ' << +values[static_cast<std::size_t>(i)];
  out << '\n';
}

/// The status as one word.
std::string wordOf(QpccStatus status) {
  std::string word = nameOf(status);
  for (char& letter : word) letter = letter == ' ' ? '_' : letter;
  return word;
}

void writeVector(std::ostream& out, const char* name, const VecX& values, int count) {
  writeLine(out, name, std::vector<double>(values.data(), values.data() + count), count);
}

}  // namespace

void writeQpccRecord(std::ostream& out, const QpccRecord& record) {
  const QpccSizes& size = record.problem.size;
  const QpccGuess& guess = record.guess;
  const QpccSolution& solution = record.solution;
  const auto old_digits = out.precision(kDigits);
  out << "record " << record.cycle << ' ' << record.time;
  for (const std::string& name : record.names) out << ' ' << name;
  out << '\n';
  writeQpcc(out, record.problem);
  out << "guess " << guess.valid << ' ' << guess.margin << ' ' << guess.offset << '\n';
  writeVector(out, "x", guess.x, size.unknowns);
  writeLine(out, "active", guess.active, size.contacts);
  writeVector(out, "row", guess.row, size.rows);
  writeVector(out, "reach", guess.reach, size.rows);
  out << "solution " << wordOf(solution.status) << ' ' << solution.objective << ' ' << solution.proved_global << ' '
      << solution.declined_better << '\n';
  writeVector(out, "x", solution.x, size.unknowns);
  writeVector(out, "z", solution.z, size.contacts);
  writeLine(out, "active", solution.active, size.contacts);
  for (const QpccVisit& visit : record.visits) {
    out << "visit " << visit.descent << ' ' << visit.objective;
    writeVector(out, "", visit.x, size.unknowns);
  }
  out << "done\n";
  out.precision(old_digits);
}

}  // namespace sinew
