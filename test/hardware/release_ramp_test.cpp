#include "sinew/hardware/release_ramp.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

Time at(double s) {
  return Time(duration(10 + s));
}

TEST(ReleaseRamp, FallsFromAllToNothing) {
  ReleaseRamp ramp(2, 0.4);
  EXPECT_FALSE(ramp.active());
  ramp.start({false, true});
  ASSERT_TRUE(ramp.active());
  EXPECT_EQ(ramp.which(), std::vector<bool>({false, true}));
  EXPECT_EQ(ramp.share(at(0)), 1);
  EXPECT_NEAR(ramp.share(at(0.1)), 0.75, 1e-9);
  EXPECT_NEAR(ramp.share(at(0.3)), 0.25, 1e-9);
  EXPECT_EQ(ramp.share(at(0.5)), 0);
}

TEST(ReleaseRamp, BeginsAtItsFirstCallWheneverThatIs) {
  ReleaseRamp ramp(1, 0.4);
  ramp.start({true});
  EXPECT_EQ(ramp.share(at(100)), 1);
  ramp.start({true});
  EXPECT_EQ(ramp.share(at(200)), 1) << "started anew";
}

TEST(ReleaseRamp, NothingChosenIsNothingToDo) {
  ReleaseRamp ramp(2, 0.4);
  ramp.start({false, false});
  EXPECT_FALSE(ramp.active());
}

TEST(ReleaseRamp, WithoutATimeItIsOverAtTheSecondCall) {
  ReleaseRamp ramp(1, 0);
  ramp.start({true});
  EXPECT_EQ(ramp.share(at(0)), 1) << "whoever relaxes learns what there was";
  EXPECT_EQ(ramp.share(at(0)), 0);
}

}  // namespace
}  // namespace sinew
