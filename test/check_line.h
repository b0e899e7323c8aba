#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <string>

namespace sinew {

/// States one figure of the validation: expects `value op bound` and prints it as a line that scripts can collect.
inline void checkFigure(const std::string& name, double value, const std::string& op, double bound,
                        const std::string& unit) {
  std::printf("check=%s value=%.6g op=%s bound=%g unit=%s\n", name.c_str(), value, op.c_str(), bound, unit.c_str());
  if (op == "<=") {
    EXPECT_LE(value, bound) << name;
  } else {
    EXPECT_GE(value, bound) << name;
  }
  EXPECT_FALSE(std::isnan(value)) << name;
}

}  // namespace sinew
