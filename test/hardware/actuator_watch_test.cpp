#include "sinew/hardware/actuator_watch.h"

#include <gtest/gtest.h>

#include <limits>

namespace sinew {
namespace {

constexpr double kDt = 0.01;  // s
const double kUnknown = std::numeric_limits<double>::quiet_NaN();

ActuatorDescription makeCable() {
  ActuatorDescription a;
  a.watch.difference_max = 0.005;
  a.watch.effort_missing = 3;
  a.watch.time = 0.1;
  a.watch.temperature_max = 70;
  a.watch.current_max = 2;
  return a;
}

ActuatorReading makeReading(double measured, double effort) {
  ActuatorReading r;
  r.valid = true;
  r.measured = measured;
  r.effort = effort;
  return r;
}

/// Cycles until the watch complains, at most `most`; -1 when it does not.
int cyclesUntilFault(ActuatorWatch& watch, const ActuatorReading& reading, double applied, double expected,
                     int most = 50) {
  for (int n = 1; n <= most; ++n)
    if (!watch.update({reading}, {applied}, &expected, kDt)) return n;
  return -1;
}

TEST(ActuatorWatch, ADifferenceThatLastsIsAFault) {
  ActuatorWatch watch({makeCable()});
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0.004, 0), 0, kUnknown), -1);
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(-0.006, 0), 0, kUnknown), 11);
  EXPECT_EQ(watch.fault(0), kFaultDifference);
}

TEST(ActuatorWatch, AShortOneIsNone) {
  ActuatorWatch watch({makeCable()});
  for (int round = 0; round < 20; ++round) {
    EXPECT_EQ(cyclesUntilFault(watch, makeReading(0.02, 0), 0, kUnknown, 9), -1);
    EXPECT_EQ(cyclesUntilFault(watch, makeReading(0, 0), 0, kUnknown, 1), -1);
  }
}

TEST(ActuatorWatch, ACableWithoutTheTensionThatIsExpectedHasSnapped) {
  ActuatorWatch watch({makeCable()});
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0, 0.1), 0, 3), -1) << "within the tolerance";
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0, 9), 0, 4), -1) << "more than expected is an obstacle";
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0, 0.1), 0, kUnknown), -1) << "nobody says what to expect";
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0, 0.1), 0, 5), 11);
  EXPECT_EQ(watch.fault(0), kFaultDifference);
}

TEST(ActuatorWatch, HeatActsAtOnceAndCurrentWhenItLasts) {
  ActuatorWatch hot({makeCable()}), strong({makeCable()});
  ActuatorReading reading = makeReading(0, 0);
  reading.temperature = 71;
  EXPECT_EQ(cyclesUntilFault(hot, reading, 0, kUnknown), 1);
  EXPECT_EQ(hot.fault(0), kFaultHot);
  reading.temperature = 0;
  reading.current = -2.1;
  EXPECT_EQ(cyclesUntilFault(strong, reading, 0, kUnknown), 11);
  EXPECT_EQ(strong.fault(0), kFaultCurrent);
}

TEST(ActuatorWatch, PressureActsAtOnce) {
  ActuatorDescription channel;
  channel.quantity = Quantity::kPressure;
  channel.watch.pressure_max = 1e5;
  ActuatorWatch watch({channel});
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0.99e5, 0), 0, kUnknown), -1);
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(1.01e5, 0), 0, kUnknown), 1);
  EXPECT_EQ(watch.fault(0), kFaultPressure);
}

TEST(ActuatorWatch, AReadingThatDidNotComeIsNoMeasurement) {
  ActuatorWatch watch({makeCable()});
  ActuatorReading reading = makeReading(1, 0);
  reading.valid = false;
  EXPECT_EQ(cyclesUntilFault(watch, reading, 0, 100), -1);
}

TEST(ActuatorWatch, StaysUntilReset) {
  ActuatorWatch watch({makeCable()});
  ASSERT_GT(cyclesUntilFault(watch, makeReading(1, 0), 0, kUnknown), 0);
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0, 0), 0, kUnknown), 1) << "latched";
  watch.reset();
  EXPECT_EQ(cyclesUntilFault(watch, makeReading(0, 0), 0, kUnknown), -1);
}

}  // namespace
}  // namespace sinew
