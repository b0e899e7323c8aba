#include "sinew/common/config_error.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

TEST(ConfigError, SaysWhatWasFoundWhereAndWhatWouldBeRight) {
  const ConfigError error("robot.yaml: mesh.scale", "'-1'", "a number > 0");
  EXPECT_STREQ(error.what(), "robot.yaml: mesh.scale: found '-1', expected a number > 0");
}

TEST(ConfigError, TakesAWholeSentenceToo) {
  EXPECT_STREQ(ConfigError("the port is busy").what(), "the port is busy");
}

TEST(ConfigError, IsCaughtAsARuntimeError) {
  EXPECT_THROW(throw ConfigError("a", "b", "c"), std::runtime_error);
}

}  // namespace
}  // namespace sinew
