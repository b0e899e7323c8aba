#include "sinew/hardware/simulated_pressure_bus.h"

#include <gtest/gtest.h>

#include "sinew/common/config_error.h"
#include "sinew/hardware/pressure_message.h"

namespace sinew {
namespace {

using Bytes = std::vector<std::uint8_t>;

const Time kStart{std::chrono::seconds(10)};

Bytes makeHello(std::uint8_t address) {
  PressureRequest hello;
  hello.type = PressureType::kHello;
  Bytes bytes;
  appendPressureRequest(address, hello, bytes);
  return bytes;
}

TEST(SimulatedPressureBus, RefusesPlacesThatNoBoardHas) {
  EXPECT_THROW(SimulatedPressureBus({{1, 4}}), ConfigError);
  EXPECT_THROW(SimulatedPressureBus({{1, -1}}), ConfigError);
  EXPECT_THROW(SimulatedPressureBus({{0, 0}}), ConfigError);
  EXPECT_EQ(SimulatedPressureBus({{1, 0}, {2, 0}, {1, 3}}).size(), 3);
}

TEST(SimulatedPressureBus, OnlyTheBoardThatIsMeantAnswersInItsTime) {
  SimulatedPressureBus bus({{1, 0}, {9, 1}}, 57600);
  const Bytes hello = makeHello(9);
  ASSERT_EQ(hello.size(), 9u);
  bus.receive(hello.data(), hello.size(), kStart);
  const std::size_t answer = pressureFrameSize(PressureType::kIdentity, 0);
  const double expected = static_cast<double>(hello.size() + answer) * 10 / 57600 + 200e-6;
  EXPECT_NEAR(seconds(bus.nextDue() - kStart), expected, 1e-6);
  Bytes out(300);
  EXPECT_EQ(bus.transmit(out.data(), out.size(), kStart + duration(expected - 1e-5)), 0u);
  EXPECT_EQ(bus.transmit(out.data(), out.size(), kStart + duration(expected + 1e-5)), answer);
  EXPECT_EQ(out[1], 9);
}

TEST(SimulatedPressureBus, FaultsReachTheBoardOfTheActuator) {
  SimulatedPressureBus bus({{1, 0}, {9, 1}});
  const auto answers = [&bus](std::uint8_t address) {
    static Time now = kStart;
    now += duration(1);
    const Bytes hello = makeHello(address);
    bus.receive(hello.data(), hello.size(), now);
    Bytes out(300);
    return bus.transmit(out.data(), out.size(), now + duration(0.9)) > 0;
  };
  bus.setFrozen(1, true);
  EXPECT_TRUE(answers(1));
  EXPECT_FALSE(answers(9));
  bus.setFrozen(1, false);
  EXPECT_TRUE(answers(9));
  bus.setSupplyVoltage(0);
  EXPECT_FALSE(answers(1) || answers(9)) << "one supply for all";
}

}  // namespace
}  // namespace sinew
