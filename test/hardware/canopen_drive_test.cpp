#include "sinew/hardware/canopen_drive.h"

#include <gtest/gtest.h>

#include <cmath>

#include "hardware/canopen_bench.h"
#include "sinew/common/config_error.h"
#include "sinew/hardware/simulated_cia402_drive.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.01, kWatchdog = 0.1, kRadius = 0.01, kTensionMax = 20;
constexpr int kMissingLimit = 5;
constexpr std::uint8_t kNode = 5;

CanopenSettings makeSettings(std::uint8_t node = kNode) {
  CanopenSettings s;
  s.node = node;
  s.driver_node = 127;
  s.counts_per_turn = 4096;
  s.gear = 10;
  s.rated_unit = 1e-3;
  s.heartbeat = 0.05;
  return s;
}

WinchDescription makeCable() {
  WinchDescription cable;
  cable.spool_radius = kRadius;
  cable.sign = 1;
  cable.torque_constant = 0.5;
  cable.tension_max = kTensionMax;
  return cable;
}

ActuatorBounds makeBounds() {
  return {"cable", -0.1, 0.1, 0.2};
}

DeviceTiming makeTiming() {
  return {kPeriod, kWatchdog, 0.004, kMissingLimit};
}

struct Rig {
  explicit Rig(const CanopenSettings& settings = makeSettings(), const WinchDescription& cable = makeCable(),
               const SimulatedCia402Drive::Parameters& parameters = {})
      : node(settings.node, parameters), drive(settings, cable, makeBounds(), makeTiming()) {
    bench.add(node);
    bench.add(drive);
  }
  const ActuatorReading& reading() const { return drive.readings()[0]; }
  SetUpProgress setUp(bool home_all = false) { return bench.setUp(drive, home_all); }
  void cycle(double set_point) { bench.cycle({set_point}); }
  void cycles(int count, double set_point) {
    for (int i = 0; i < count; ++i) cycle(set_point);
  }

  CanopenBench bench{kPeriod};
  SimulatedCia402Drive node;
  CanopenDrive drive;
};

TEST(CanopenDrive, SetsUpAndFollows) {
  Rig rig;
  ASSERT_EQ(rig.setUp(), SetUpProgress::kDone) << rig.drive.problem();
  EXPECT_TRUE(rig.node.energised(0));
  EXPECT_EQ(rig.node.shaftAngle(0), 0);
  rig.cycles(100, 0.01);
  EXPECT_NEAR(rig.reading().measured, 0.01, 1e-5);
  EXPECT_NEAR(rig.node.shaftAngle(0), 1, 1e-3);
  EXPECT_EQ(rig.reading().fault, 0u);
  EXPECT_TRUE(rig.reading().valid);
}

}  // namespace
}  // namespace sinew
