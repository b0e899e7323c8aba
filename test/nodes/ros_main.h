#pragma once

#include <gtest/gtest.h>
#include <ros/ros.h>

#include <cstdio>
#include <string>

#include "real_time.h"

namespace sinew {

/// All tests of a program as the node `name`, at the priority that nodes ask for.
inline int runTestsAsNode(int argc, char** argv, const std::string& name) {
  const std::string not_allowed = requestRealTime();
  if (!not_allowed.empty()) std::printf("not in real time: %s\n", not_allowed.c_str());
  ::testing::InitGoogleTest(&argc, argv);
  ros::init(argc, argv, name);
  ros::start();
  const int result = RUN_ALL_TESTS();
  ros::shutdown();
  return result;
}

}  // namespace sinew
