#include "sinew/hardware/cable_homing.h"

#include <gtest/gtest.h>

namespace sinew {
namespace {

using Progress = CableHoming::Progress;

ActuatorDescription make(HomingMethod method) {
  ActuatorDescription a;
  a.cable.homing.method = method;
  a.cable.homing.tension = 2;
  a.cable.homing.speed = 0.01;
  a.cable.homing.travel = 0.05;
  return a;
}

/// Two cables that become taut at 10 and 20 mm, with 1 N/mm from there.
std::vector<ActuatorReading> read(const std::vector<double>& displacement) {
  std::vector<ActuatorReading> out(displacement.size());
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].valid = true;
    out[i].measured = displacement[i];
    out[i].effort = std::max(0., 1000 * (displacement[i] - 0.01 * static_cast<double>(i + 1)));
  }
  return out;
}

TEST(CableHoming, PresentIsDoneAtOnce) {
  CableHoming homing({make(HomingMethod::kPresent)});
  homing.start(read({0.3}), {false});
  EXPECT_EQ(homing.update(read({0.3}), 0.01), Progress::kDone);
  EXPECT_EQ(homing.setPoints()[0], 0.3);
}

TEST(CableHoming, EachCableStopsWhereItIsTaut) {
  CableHoming homing({make(HomingMethod::kTension), make(HomingMethod::kTension)});
  homing.start(read({0, 0}), {false, false});
  Progress progress = Progress::kBusy;
  double last[2] = {0, 0};
  for (int n = 0; n < 1000 && progress == Progress::kBusy; ++n) {
    progress = homing.update(read(homing.setPoints()), 0.01);
    for (std::size_t i = 0; i < 2; ++i) {
      EXPECT_LE(homing.setPoints()[i] - last[i], 0.01 * 0.01 + 1e-12) << "no faster than its speed";
      last[i] = homing.setPoints()[i];
    }
  }
  EXPECT_EQ(progress, Progress::kDone);
  EXPECT_NEAR(homing.setPoints()[0], 0.012, 2e-4);
  EXPECT_NEAR(homing.setPoints()[1], 0.022, 2e-4);
}

TEST(CableHoming, ASingleSpikeOrAnInvalidReadingIsNotATension) {
  CableHoming homing({make(HomingMethod::kTension)});
  homing.start(read({0}), {false});
  for (int n = 0; n < 300; ++n) {
    std::vector<ActuatorReading> readings = read({0});
    readings[0].effort = n % 3 == 0 ? 0 : 100;
    ASSERT_EQ(homing.update(readings, 0.001), Progress::kBusy);
    readings[0].valid = false;
    ASSERT_EQ(homing.update(readings, 0.001), Progress::kBusy);
  }
}

TEST(CableHoming, GivesUpAfterItsTravel) {
  CableHoming homing({make(HomingMethod::kPresent), make(HomingMethod::kTension)});
  homing.start(read({0, 0}), {false, false});
  Progress progress = Progress::kBusy;
  int cycles = 0;
  for (; progress == Progress::kBusy && cycles < 10000; ++cycles) progress = homing.update(read({0, 0}), 0.01);
  EXPECT_EQ(progress, Progress::kFailed);
  EXPECT_EQ(homing.failed(), 1);
  EXPECT_NEAR(cycles * 0.01 * 0.01, 0.05, 2e-4);
}

TEST(CableHoming, KeepsWhatNeedsNoHoming) {
  CableHoming homing({make(HomingMethod::kTension), make(HomingMethod::kTension)});
  homing.start(read({0.001, 0.0215}), {true, false});
  while (homing.update(read(homing.setPoints()), 0.01) == Progress::kBusy) {
  }
  EXPECT_EQ(homing.setPoints()[0], 0.001);
}

}  // namespace
}  // namespace sinew
