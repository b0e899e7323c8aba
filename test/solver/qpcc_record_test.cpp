#include "sinew/solver/qpcc_record.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "random_qpcc.h"
#include "sinew/solver/qpcc_text.h"

namespace sinew {
namespace {

/// A line's words.
std::vector<std::string> split(const std::string& line) {
  std::istringstream in(line);
  std::vector<std::string> words;
  for (std::string word; in >> word;) words.push_back(word);
  return words;
}

class QpccRecordTest : public testing::Test {
 protected:
  std::mt19937 random{3};
  QpccProblem problem = makeQpcc(QpccKind::kLever, 2, 5, random);
  QpccGuess guess{problem.size};
  QpccSolution solution{problem.size};
  std::vector<QpccVisit> visits;
  std::stringstream text;

  QpccRecordTest() {
    QpccSolver solver(problem.size);
    solver.watch(&visits);
    guess.valid = true;
    guess.active[2] = 1;
    solver.solve(problem, guess, QpccBudget(), solution);
    writeQpccRecord(text, {7, 0.07, {"left", "right"}, problem, guess, solution, visits});
  }

  std::vector<std::string> nextLine() {
    std::string line;
    std::getline(text >> std::ws, line);
    return split(line);
  }
};

TEST_F(QpccRecordTest, writesProblemGuessAnswerAndPath) {
  EXPECT_EQ(nextLine(), (std::vector<std::string>{"record", "7", "0.070000000000000007", "left", "right"}));
  EXPECT_EQ(readQpcc(text, "text").C_c, problem.C_c);
  EXPECT_EQ(nextLine(), (std::vector<std::string>{"guess", "1", "0", "0"}));
  EXPECT_EQ(nextLine(), (std::vector<std::string>{"x", "0", "0"}));
  EXPECT_EQ(nextLine(), (std::vector<std::string>{"active", "0", "0", "1", "0", "0"}));
  EXPECT_EQ(nextLine().size(), 3u);  // row
  EXPECT_EQ(nextLine(), (std::vector<std::string>{"reach", "inf", "inf"}));
  const std::vector<std::string> answer = nextLine();
  EXPECT_EQ(answer[0] + answer[1], "solutionsolved");
  EXPECT_EQ(std::stod(answer[2]), solution.objective);
  EXPECT_EQ(std::stod(nextLine()[2]), solution.x(1));
  EXPECT_EQ(nextLine().size(), 6u);  // z
  EXPECT_EQ(nextLine().size(), 6u);  // active
  for (const QpccVisit& visit : visits) {
    const std::vector<std::string> line = nextLine();
    EXPECT_EQ(std::stod(line[2]), visit.objective);
    EXPECT_EQ(std::stod(line[4]), visit.x(1));
  }
  EXPECT_EQ(nextLine(), (std::vector<std::string>{"done"}));
}

TEST_F(QpccRecordTest, thePathDescendsToTheAnswer) {
  ASSERT_FALSE(visits.empty());
  double best = visits.front().objective;
  for (std::size_t k = 1; k < visits.size(); ++k) {
    const double tolerance = 1e-8 * std::abs(visits[k].objective);
    if (visits[k].descent == visits[k - 1].descent) {
      EXPECT_LE(visits[k].objective, visits[k - 1].objective + tolerance);
    }
    best = std::min(best, visits[k].objective);
  }
  EXPECT_NEAR(best, solution.objective, 1e-6 * std::abs(solution.objective));
}

}  // namespace
}  // namespace sinew
