#include "sinew/solver/qpcc_text.h"

#include <algorithm>
#include <exception>
#include <limits>
#include <utility>
#include <vector>

#include "sinew/common/config_error.h"

namespace sinew {

namespace {

constexpr int kDigits = std::numeric_limits<double>::max_digits10;

using NamedMatrix = std::pair<const char*, Eigen::Ref<MatX>>;

/// The leading blocks that count, vectors as columns.
std::vector<NamedMatrix> listBlocks(QpccProblem& p) {
  const int na = p.size.unknowns;
  const int nr = p.size.rows;
  const int ne = p.size.effectors;
  const int nc = p.size.contacts;
  return {{"E_a", p.E_a.topLeftCorner(ne, na)},
          {"E_c", p.E_c.topLeftCorner(ne, nc)},
          {"e", p.e.head(ne)},
          {"Q", p.Q.topLeftCorner(na, na)},
          {"q", p.q.head(na)},
          {"x_lower", p.x_lower.head(na)},
          {"x_upper", p.x_upper.head(na)},
          {"soft_lower", p.soft_lower.head(na)},
          {"soft_upper", p.soft_upper.head(na)},
          {"A_a", p.A_a.topLeftCorner(nr, na)},
          {"A_c", p.A_c.topLeftCorner(nr, nc)},
          {"a", p.a.head(nr)},
          {"row_lower", p.row_lower.head(nr)},
          {"row_upper", p.row_upper.head(nr)},
          {"C_a", p.C_a.topLeftCorner(nc, na)},
          {"C_c", p.C_c.topLeftCorner(nc, nc)},
          {"c", p.c.head(nc)}};
}

void expectWord(std::istream& in, const std::string& word, const std::string& source) {
  std::string found;
  in >> found;
  if (found != word) throw ConfigError(source + ": expected '" + word + "' of a QPCC, found '" + found + "'");
}

/// The stream's own extraction knows no infinity.
double readNumber(std::istream& in, const std::string& block, const std::string& source) {
  std::string text;
  in >> text;
  std::size_t used = 0;
  double value = 0;
  try {
    value = std::stod(text, &used);
  } catch (const std::exception&) {
    used = 0;
  }
  if (text.empty() || used != text.size())
    throw ConfigError(source + ": expected a number of block " + block + ", found '" + text + "'");
  return value;
}

}  // namespace

void writeQpcc(std::ostream& out, const QpccProblem& problem) {
  QpccProblem copy = problem;
  const auto old_digits = out.precision(kDigits);
  const QpccSizes& size = copy.size;
  out << "qpcc " << size.unknowns << ' ' << size.rows << ' ' << size.effectors << ' ' << size.contacts << '\n';
  for (const NamedMatrix& block : listBlocks(copy)) {
    out << block.first;
    for (int i = 0; i < block.second.rows(); ++i)
      for (int j = 0; j < block.second.cols(); ++j) out << ' ' << block.second(i, j);
    out << '\n';
  }
  out << "end\n";
  out.precision(old_digits);
}

bool hasQpcc(std::istream& in) {
  return static_cast<bool>(in >> std::ws) && in.peek() != std::istream::traits_type::eof();
}

QpccProblem readQpcc(std::istream& in, const std::string& source) {
  expectWord(in, "qpcc", source);
  QpccSizes size;
  in >> size.unknowns >> size.rows >> size.effectors >> size.contacts;
  if (!in || std::min({size.unknowns, size.rows, size.effectors, size.contacts}) < 0)
    throw ConfigError(source + ": expected four sizes >= 0 after 'qpcc'");
  QpccProblem problem(size);
  for (NamedMatrix& block : listBlocks(problem)) {
    expectWord(in, block.first, source);
    for (int i = 0; i < block.second.rows(); ++i)
      for (int j = 0; j < block.second.cols(); ++j) block.second(i, j) = readNumber(in, block.first, source);
  }
  expectWord(in, "end", source);
  return problem;
}

}  // namespace sinew
