#include "zero_file.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <fstream>

namespace sinew {
namespace {

const std::string kPath = "/tmp/sinew_zero_file_test_" + std::to_string(getpid()) + ".yaml";

TEST(ZeroFile, KeepsWhatIsValidForTheNextLife) {
  ZeroFile(kPath).update({"a", "b", "c"}, {2048.25, std::nan(""), -7});
  const std::map<std::string, double> zeros = ZeroFile(kPath).take();
  EXPECT_EQ(zeros, (std::map<std::string, double>{{"a", 2048.25}, {"c", -7}}));
}

TEST(ZeroFile, IsTakenOnce) {
  ZeroFile(kPath).update({"a"}, {1});
  EXPECT_EQ(ZeroFile(kPath).take().size(), 1u);
  EXPECT_TRUE(ZeroFile(kPath).take().empty()) << "what is older than the last set-up must not come back";
}

TEST(ZeroFile, NonsenseIsNoZero) {
  std::ofstream(kPath) << "a: [1, 2\n";
  EXPECT_TRUE(ZeroFile(kPath).take().empty());
  std::ofstream(kPath) << "a: .nan\nb: 3\n";
  EXPECT_EQ(ZeroFile(kPath).take(), (std::map<std::string, double>{{"b", 3}}));
  EXPECT_TRUE(ZeroFile("/no/such/folder/file").take().empty());
  ZeroFile("/no/such/folder/file").update({"a"}, {1});
  EXPECT_TRUE(ZeroFile("").take().empty());
}

TEST(ZeroFile, StandsInTheFolderOfRos) {
  setenv("ROS_HOME", "/tmp/ros", 1);
  EXPECT_EQ(makeZeroPath("/trunk/hardware_driver"), "/tmp/ros/sinew_zeros_trunk_hardware_driver.yaml");
  unsetenv("ROS_HOME");
  setenv("HOME", "/home/x", 1);
  EXPECT_EQ(makeZeroPath("/driver"), "/home/x/.ros/sinew_zeros_driver.yaml");
}

}  // namespace
}  // namespace sinew
