#pragma once

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

namespace sinew {

/// Prints one line a result, appends it to the file that SINEW_RESULTS names, and expects value <= bound.
inline void expectAtMost(const std::string& name, double value, double bound, const std::string& unit) {
  char line[256];
  std::snprintf(line, sizeof line, "check=%s value=%.6g op=<= bound=%.6g unit=%s", name.c_str(), value, bound,
                unit.c_str());
  std::printf("%s\n", line);
  std::fflush(stdout);
  if (const char* path = std::getenv("SINEW_RESULTS")) std::ofstream(path, std::ios::app) << line << "\n";
  EXPECT_LE(value, bound) << line;
}

}  // namespace sinew
