// The map of a contact problem, which solves it by other means, against the solver's answers.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <map>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "sinew/solver/qpcc_record.h"
#include "solver/random_qpcc.h"

namespace sinew {
namespace {

constexpr int kProblems = 12;

struct Output {
  int code = 0;
  std::string text;  ///< both streams
};

Output runScript(const std::string& arguments) {
  const std::string command = SINEW_PYTHON " -B " SINEW_SOURCE_DIR "/scripts/plot_qpcc " + arguments + " 2>&1";
  Output output;
  FILE* const pipe = popen(command.c_str(), "r");
  if (!pipe) return {-1, "cannot run " + command};
  for (char buffer[4096]; std::fgets(buffer, sizeof buffer, pipe);) output.text += buffer;
  const int status = pclose(pipe);
  output.code = WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  return output;
}

/// Whether the descent alone ends at another, local minimum.
bool isTrap(const QpccSolution& solution) {
  return solution.decomposition_objective > solution.objective + 0.01 * std::abs(solution.objective);
}

/// A line of name=value pairs.
using Line = std::map<std::string, std::string>;

std::vector<Line> readLines(const std::string& text) {
  std::vector<Line> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) {
    lines.emplace_back();
    std::istringstream words(line);
    for (std::string word; words >> word;) {
      const std::size_t equals = word.find('=');
      if (equals != std::string::npos) lines.back()[word.substr(0, equals)] = word.substr(equals + 1);
    }
  }
  return lines;
}

/// Problems of two actuators within a box, recorded with the global answer and what the descent alone finds.
class PlotQpccTest : public testing::Test {
 protected:
  std::string path = testing::TempDir() + "plot_qpcc_test.txt";
  std::vector<double> best, alone;

  PlotQpccTest() {
    std::mt19937 random(5);
    std::ofstream file(path);
    constexpr QpccKind kKinds[] = {QpccKind::kLever, QpccKind::kRandom, QpccKind::kBar};
    while (static_cast<int>(best.size()) < kProblems) {
      const int cycle = static_cast<int>(best.size());
      const QpccProblem problem = makeQpcc(kKinds[cycle % 3], 2, 3 + cycle % 6, random);
      QpccSolver solver(problem.size);
      QpccSolution solution(problem.size);
      std::vector<QpccVisit> visits;
      solver.watch(&visits);
      const QpccGuess none(problem.size);
      if (solver.solve(problem, none, QpccBudget(), solution) != QpccStatus::kSolved) continue;
      if (!solution.proved_global || (cycle % 3 == 0 && !isTrap(solution))) continue;
      best.push_back(solution.objective);
      alone.push_back(solution.decomposition_objective);
      writeQpccRecord(file, {cycle, 0.01 * cycle, {"left", "right"}, problem, none, solution, visits});
    }
  }
  ~PlotQpccTest() override { std::remove(path.c_str()); }
};

TEST_F(PlotQpccTest, findsTheSolversMinima) {
  int trapped = 0;
  for (int cycle = 0; cycle < kProblems; ++cycle) {
    const auto index = static_cast<std::size_t>(cycle);
    const Output output = runScript(path + " --grid 121 --cycle " + std::to_string(cycle));
    ASSERT_EQ(output.code, 0) << output.text;
    const std::vector<Line> lines = readLines(output.text);
    ASSERT_GE(lines.size(), 2u) << output.text;
    const Line& global = lines.front();
    const Line& answer = lines.back();
    EXPECT_EQ(global.at("minimum"), "global");
    EXPECT_NEAR(std::stod(global.at("objective")), best[index], 1e-6 * std::abs(best[index])) << output.text;
    EXPECT_NEAR(std::stod(answer.at("objective")), best[index], 1e-8 * std::abs(best[index]));
    EXPECT_NEAR(std::stod(global.at("left")), std::stod(answer.at("left")), 2e-5);
    EXPECT_NEAR(std::stod(global.at("right")), std::stod(answer.at("right")), 2e-5);
    if (alone[index] < best[index] + 0.01 * std::abs(best[index])) continue;
    ++trapped;
    const auto same = [&](const Line& line) {
      return std::abs(std::stod(line.at("objective")) - alone[index]) <= 1e-5 * std::abs(alone[index]);
    };
    EXPECT_TRUE(std::any_of(lines.begin() + 1, lines.end() - 1, same)) << alone[index] << " is not in\n" << output.text;
  }
  EXPECT_GE(trapped, 4);
}

TEST_F(PlotQpccTest, mapsEffortsToo) {
  const Output output = runScript(path + " --grid 61 --efforts --cycle 3");
  ASSERT_EQ(output.code, 0) << output.text;
  EXPECT_NEAR(std::stod(readLines(output.text).front().at("objective")), best[3], 1e-6 * std::abs(best[3]));
}

TEST_F(PlotQpccTest, drawsAMap) {
  const std::string map = testing::TempDir() + "plot_qpcc_test.png";
  const Output output = runScript(path + " --grid 61 --cycle 0 --out " + map);
  if (output.text.find("install python3-matplotlib") != std::string::npos) GTEST_SKIP() << output.text;
  ASSERT_EQ(output.code, 0) << output.text;
  std::ifstream file(map, std::ios::binary);
  char magic[4] = {};
  file.read(magic, 4);
  EXPECT_EQ(std::string(magic + 1, 3), "PNG");
  std::remove(map.c_str());
}

TEST_F(PlotQpccTest, namesWhatIsWrong) {
  const auto complaintOf = [&](const std::string& arguments) {
    const Output output = runScript(arguments);
    EXPECT_NE(output.code, 0) << arguments;
    EXPECT_EQ(output.text.find("Traceback"), std::string::npos) << output.text;
    return output.text;
  };
  EXPECT_NE(complaintOf(path + " --cycle 99").find("no cycle 99"), std::string::npos);
  EXPECT_NE(complaintOf(path + " --actuators left middle").find("no 'middle'; there are left, right"),
            std::string::npos);
  EXPECT_NE(complaintOf(path + " --actuators left left").find("two different"), std::string::npos);
  EXPECT_NE(complaintOf("no_such_file").find("No such file"), std::string::npos);
  std::ofstream(path) << "record 0 0 left right\nqpcc 2 2 3 x\n";
  EXPECT_NE(complaintOf(path).find("record 1"), std::string::npos);
  std::ofstream(path) << "";
  EXPECT_NE(complaintOf(path).find("no cycle in it"), std::string::npos);
  EXPECT_EQ(runScript("--help").code, 0);
}

}  // namespace
}  // namespace sinew
