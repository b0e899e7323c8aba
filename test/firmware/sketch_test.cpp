#include <gtest/gtest.h>

#include "firmware/arduino/Arduino.h"
#include "pressure_examples.h"

// The sketch as it is, on an Arduino in the test's hand.
#include "../../firmware/arduino/sinew_board/sinew_board.ino"

namespace sinew {
namespace {

using Bytes = PressureExample::Bytes;

class Sketch : public testing::Test {
 protected:
  Sketch() {
    fake_arduino = FakeArduino();
    Serial = FakeSerial();
    for (const std::uint8_t pin : kSensorPins) fake_arduino.analog[pin] = 41;  // 0.04 of 1023: no pressure
    fake_arduino.analog[kSupplyPin] = 767;                                     // 12 V
    fake_arduino.analog[kTemperaturePin] = 153;                                // 25 degC
    fake_arduino.digital[kStopPin] = LOW;
    fake_arduino.digital[kTankSwitchPin] = LOW;
    setup();
  }

  void pass(int ms) {
    for (int n = 0; n < ms; ++n) {
      ++fake_arduino.now;
      loop();
    }
  }

  Bytes ask(std::uint8_t type, std::uint16_t sequence, const Bytes& payload) {
    Bytes packet{kAddress, type, static_cast<std::uint8_t>(sequence), static_cast<std::uint8_t>(sequence >> 8)};
    packet.insert(packet.end(), payload.begin(), payload.end());
    const std::uint16_t crc = sinew_crc(packet.data(), packet.size());
    packet.push_back(static_cast<std::uint8_t>(crc));
    packet.push_back(static_cast<std::uint8_t>(crc >> 8));
    Bytes frame(packet.size() + 1);
    sinew_stuff(packet.data(), packet.size(), frame.data());
    Serial.in.assign(frame.begin(), frame.end());
    Serial.in.push_back(0);
    Serial.out.clear();
    pass(1);
    if (Serial.out.empty()) return {};
    Bytes plain(Serial.out.size());
    plain.resize(sinew_unstuff(Serial.out.data(), Serial.out.size() - 1, plain.data()));
    return plain;
  }

  bool vents(std::size_t channel) {
    return fake_arduino.written[kFillPins[channel]] == 0 && fake_arduino.written[kExhaustPins[channel]] == 0;
  }
};

TEST_F(Sketch, BootsVentedWithItsWatchdogOn) {
  EXPECT_TRUE(vents(0) && vents(1));
  EXPECT_TRUE(fake_arduino.watched);
  EXPECT_EQ(fake_arduino.written[kPumpPin], LOW);
  EXPECT_EQ(Serial.baud, kBaud);
}

TEST_F(Sketch, ReadsItsSensorsAsTheirDataSheetsSay) {
  fake_arduino.analog[kSensorPins[1]] = 501;  // 5 V (0.009 * 50 + 0.04) = 2.45 V
  EXPECT_NEAR(readPressure(nullptr, 1), 50000, 110);
  EXPECT_NEAR(readPressure(nullptr, 0), 0, 110);
  for (const int counts : {0, 1023}) {
    fake_arduino.analog[kSensorPins[1]] = counts;
    EXPECT_GT(readPressure(nullptr, 1), 1000000) << "open or short";
  }
  EXPECT_NEAR(readSupply(nullptr), 12000, 20);
  EXPECT_NEAR(readTemperature(nullptr), 250, 5);
}

TEST_F(Sketch, FillsWhenToldAndVentsInSilence) {
  const Bytes identity = ask(SINEW_HELLO, 1, {1});
  ASSERT_EQ(identity.size(), 22u);
  EXPECT_EQ(identity[7], kChannels);
  const Bytes channel{0x50, 0xC3, 0, 0, 0x50, 0xC3, 0, 0, 0};  // 50 kPa, 50 kPa/s, vent
  Bytes configure{100, 0, 2};
  for (int i = 0; i < 2; ++i) configure.insert(configure.end(), channel.begin(), channel.end());
  ASSERT_EQ(ask(SINEW_CONFIGURE, 2, configure)[1], SINEW_CONFIGURATION);
  const Bytes vented(13, 0), filled{1, 0x20, 0x4E, 0, 0, 0x50, 0xC3, 0, 0, 0x50, 0xC3, 0, 0};  // 20 kPa
  Bytes set_points{2};
  set_points.insert(set_points.end(), filled.begin(), filled.end());
  set_points.insert(set_points.end(), vented.begin(), vented.end());
  const Bytes state = ask(SINEW_SET_POINTS, 3, set_points);
  ASSERT_EQ(state[1], SINEW_STATE);
  EXPECT_EQ(state[17], SINEW_ACCEPTED);
  pass(90);
  EXPECT_GE(fake_arduino.written[kFillPins[0]], 60);
  EXPECT_EQ(fake_arduino.written[kExhaustPins[0]], 255) << "held closed";
  EXPECT_TRUE(vents(1));
  pass(20);
  EXPECT_TRUE(vents(0));
}

TEST_F(Sketch, EmergencyStopVentsAlsoWithItsWireBroken) {
  fake_arduino.digital.erase(kStopPin);
  pass(5);
  const Bytes state = ask(SINEW_READ_STATE, 1, {});
  EXPECT_EQ(state[16], SINEW_FLAG_STOP);
  EXPECT_EQ(state[24], SINEW_FAULT_STOP);
}

}  // namespace
}  // namespace sinew
