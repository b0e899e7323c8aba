#pragma once

#include <gtest/gtest.h>

#include <cstdio>

namespace sinew {

/// Asserts value <= bound (or >=) and prints the check as one plain line for whoever collects them.
inline void checkAtMost(const char* check, double value, double bound, const char* unit) {
  std::printf("check=%s value=%.9g op=<= bound=%.9g unit=%s\n", check, value, bound, unit);
  EXPECT_LE(value, bound) << check;
}

inline void checkAtLeast(const char* check, double value, double bound, const char* unit) {
  std::printf("check=%s value=%.9g op=>= bound=%.9g unit=%s\n", check, value, bound, unit);
  EXPECT_GE(value, bound) << check;
}

}  // namespace sinew
