// `rosrun sinew check` as a user calls it.

#include <gtest/gtest.h>
#include <sys/wait.h>

#include <array>
#include <cstdio>
#include <memory>
#include <string>

namespace sinew {
namespace {

struct Answer {
  int code = -1;
  std::string words;
};

Answer run(const std::string& arguments) {
  Answer answer;
  FILE* const pipe = popen((SINEW_CHECK " " + arguments + " 2>&1").c_str(), "r");
  std::array<char, 256> line;
  while (std::fgets(line.data(), static_cast<int>(line.size()), pipe) != nullptr) answer.words += line.data();
  const int status = pclose(pipe);
  if (WIFEXITED(status)) answer.code = WEXITSTATUS(status);
  return answer;
}

std::string robot(const std::string& name) {
  return std::string(SINEW_SOURCE_DIR) + "/config/" + name + "/" + name + ".yaml --cycles 20";
}

bool says(const Answer& answer, const std::string& words) {
  return answer.words.find(words) != std::string::npos;
}

TEST(Check, saysWhereTheTimeGoes) {
  const Answer answer = run(robot("finger"));
  EXPECT_EQ(answer.code, 0) << answer.words;
  for (const char* const words : {"assembly", "factor", "detection", "compliance", "quadratic programmes", "advance",
                                  "whole cycle", "contacts", "obstacle", "rate       up to", "faster"}) {
    EXPECT_TRUE(says(answer, words)) << words << " in\n" << answer.words;
  }
}

TEST(Check, aRateThatIsReachedIsFine) {
  EXPECT_EQ(run(robot("finger") + " --rate 0.01").code, 0);
}

TEST(Check, aRateThatIsNotReachedIsSaid) {
  const Answer answer = run(robot("finger") + " --rate 1e7");
  EXPECT_EQ(answer.code, 3);
  EXPECT_TRUE(says(answer, "1e+07 Hz are asked for, this machine reaches")) << answer.words;
}

TEST(Check, wrongLinesAreRefused) {
  EXPECT_EQ(run("").code, 2);
  EXPECT_EQ(run(robot("finger") + " --rate 0").code, 2);
  EXPECT_EQ(run(robot("finger") + " --rate fast").code, 2);
  EXPECT_EQ(run("nowhere.yaml").code, 1);
}

}  // namespace
}  // namespace sinew
