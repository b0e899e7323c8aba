#include "control_mode.h"

#include <gtest/gtest.h>

#include <atomic>
#include <string>
#include <thread>

namespace sinew {
namespace {

constexpr double kPeriod = 1e-4;  // s

TEST(ControlMode, beginsDisabled) {
  ControlMode mode(kPeriod);
  EXPECT_EQ(mode.grant(), Mode::kFollowing);
  EXPECT_FALSE(mode.enabled());
  EXPECT_EQ(mode.disabledReason(), std::string("not enabled yet"));
}

TEST(ControlMode, cycleMayDisableOnlyWhatIsEnabled) {
  ControlMode mode(kPeriod);
  std::thread service([&mode] { mode.release(Mode::kControlling, ""); });
  service.join();
  EXPECT_TRUE(mode.enabled());
  EXPECT_EQ(mode.grant(), Mode::kControlling);
  mode.disable("the driver is gone");
  EXPECT_EQ(mode.grant(), Mode::kFollowing);
  EXPECT_EQ(mode.disabledReason(), std::string("the driver is gone"));
}

// Whoever has the controller writes to it; a value that both write shows whether they ever have it together.
TEST(ControlMode, theControllerHasOneOwner) {
  ControlMode mode(kPeriod);
  std::atomic<bool> stop{false};
  long controller = 0, cycles = 0, mine = 0;
  std::thread cycle([&] {
    while (!stop) {
      if (mode.grant() == Mode::kParked) continue;
      ++controller;
      ++cycles;
    }
  });
  for (int k = 0; k < 200; ++k) {
    mode.park();
    for (int i = 0; i < 1000; ++i, ++mine) ++controller;
    mode.release(k % 2 == 0 ? Mode::kControlling : Mode::kFollowing, "");
  }
  stop = true;
  cycle.join();
  EXPECT_EQ(controller, cycles + mine);
  EXPECT_EQ(mine, 200 * 1000);
}

// Asked to park just as the cycle gives up: the service thread gets what it asked for.
TEST(ControlMode, parkingWinsOverDisabling) {
  ControlMode mode(kPeriod);
  std::atomic<bool> stop{false};
  std::thread cycle([&] {
    while (!stop) {
      if (mode.grant() == Mode::kControlling) mode.disable("lost");
    }
  });
  for (int k = 0; k < 200; ++k) {
    mode.park();
    EXPECT_FALSE(mode.enabled());
    mode.release(Mode::kControlling, "");
  }
  stop = true;
  cycle.join();
}

}  // namespace
}  // namespace sinew
