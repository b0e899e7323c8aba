#include "sinew/solver/qpcc_text.h"

#include <gtest/gtest.h>

#include <random>
#include <sstream>

#include "random_qpcc.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

TEST(QpccText, readsBackToTheLastBit) {
  std::mt19937 random(1);
  const QpccProblem first = makeQpcc(QpccKind::kRandom, 3, 4, random);
  QpccProblem second = makeQpcc(QpccKind::kBar, 2, 6, random);
  second.resize({2, 2, 3, 5});
  std::stringstream text;
  writeQpcc(text, first);
  writeQpcc(text, second);
  ASSERT_TRUE(hasQpcc(text));
  const QpccProblem a = readQpcc(text, "text");
  const QpccProblem b = readQpcc(text, "text");
  EXPECT_FALSE(hasQpcc(text));
  EXPECT_EQ(a.C_c, first.C_c);
  EXPECT_EQ(a.E_a, first.E_a);
  EXPECT_EQ(a.x_lower, first.x_lower);  // infinite
  EXPECT_EQ(a.soft_upper, first.soft_upper);
  EXPECT_EQ(a.row_upper, first.row_upper);
  EXPECT_EQ(b.size.contacts, 5);
  EXPECT_EQ(b.C_c, second.C_c.topLeftCorner(5, 5));
  EXPECT_EQ(b.Q, second.Q);
  EXPECT_EQ(b.c, second.c.head(5));
}

TEST(QpccText, namesWhatIsWrong) {
  const auto messageOf = [](const std::string& text) -> std::string {
    std::istringstream in(text);
    try {
      readQpcc(in, "cycle.txt");
    } catch (const ConfigError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(messageOf("qp 1 0 0 0").find("cycle.txt"), std::string::npos);
  EXPECT_NE(messageOf("qpcc 1 0 -1 0").find("sizes"), std::string::npos);
  EXPECT_NE(messageOf("qpcc 1 0 0 0 E_a E_c e Q one").find("one"), std::string::npos);
  EXPECT_NE(messageOf("qpcc 1 0 0 0 E_a E_c e Q 1 x_lower 0").find("'q'"), std::string::npos);
}

}  // namespace
}  // namespace sinew
