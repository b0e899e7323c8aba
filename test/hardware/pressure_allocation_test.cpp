#include <gtest/gtest.h>

#include <algorithm>

#include "firmware/board_bench.h"
#include "hardware/pressure_bench.h"
#include "sinew/hardware/can_pressure_board.h"
#include "solver/allocation_count.h"

namespace sinew {
namespace {

DeviceTiming makeTiming() {
  DeviceTiming timing = makePressureTiming();
  timing.watchdog = 0.1;
  return timing;
}

std::vector<PressureActuator> makeActuators() {
  std::vector<PressureActuator> actuators = makePressureActuators(2);
  actuators[1].settings.channel = 1;
  return actuators;
}

/// A line straight into the firmware, which takes no memory itself.
struct FirmwareLine : ByteStream {
  FirmwareLine() { sinew_serial_start(&link, &bench.board, 11); }

  StreamResult read(std::uint8_t* data, std::size_t, Duration) override {
    std::copy_n(answer, size, data);
    const std::size_t count = size;
    size = 0;
    return {count > 0 ? StreamStatus::kOk : StreamStatus::kTimeout, count};
  }
  StreamResult write(const std::uint8_t* data, std::size_t count, Duration) override {
    for (std::size_t i = 0; i < count; ++i) size = std::max(size, sinew_serial_take(&link, data[i], answer));
    return {StreamStatus::kOk, count};
  }

  BoardBench bench;
  sinew_serial_link link{};
  std::uint8_t answer[SINEW_MAX_FRAME] = {};
  std::size_t size = 0;
};

/// The same for CAN.
struct FirmwareBus : CanSender {
  FirmwareBus() { sinew_can_start(&link, &bench.board, 11); }

  bool send(const CanFrame& frame) override {
    sinew_can_frame in{};
    in.id = frame.id;
    in.size = frame.size;
    std::copy(frame.data.begin(), frame.data.end(), in.data);
    count += sinew_can_take(&link, &in, answers + count);
    return true;
  }
  void deliver(CanDevice& device) {
    for (std::size_t i = 0; i < count; ++i) {
      CanFrame frame;
      frame.id = answers[i].id;
      frame.extended = true;
      frame.size = answers[i].size;
      std::copy_n(answers[i].data, 8, frame.data.begin());
      device.take(frame, Time{});
    }
    count = 0;
  }

  BoardBench bench;
  sinew_can_link link{};
  sinew_can_frame answers[4 * SINEW_MAX_CAN_FRAMES] = {};
  std::size_t count = 0;
};

TEST(PressureAllocation, ACycleOnASerialLineTakesNoMemory) {
  if (!countsAllocations()) GTEST_SKIP();
  const auto line = std::make_shared<FirmwareLine>();
  SerialPressureBus bus([line](std::string&) { return line; }, 1000000, makeTiming(), makeActuators());
  std::string why;
  ASSERT_TRUE(bus.open(why));
  bus.startSetUp(true);
  while (bus.updateSetUp(Time{}) == SetUpProgress::kBusy) {
  }
  const double set_points[] = {20000, 30000};
  const std::vector<bool> which{true, false};
  const auto cycle = [&] {
    bus.writeSetPoints(set_points, Time{});
    bus.read(Time{});
    line->bench.pass(10);
  };
  cycle();
  const long before = allocationCount();
  for (int n = 0; n < 100; ++n) cycle();
  bus.relax(which, 0.5);
  line->bench.stop = true;
  for (int n = 0; n < 100; ++n) cycle();
  bus.switchOff(which);
  EXPECT_EQ(allocationCount(), before);
  EXPECT_EQ(bus.readings()[0].fault, kFaultDevice);
}

TEST(PressureAllocation, ACycleOnACanBusTakesNoMemory) {
  if (!countsAllocations()) GTEST_SKIP();
  FirmwareBus bus;
  CanPressureBoard device(11, makeTiming(), makeActuators());
  device.startSetUp(true);
  while (device.updateSetUp(Time{}, bus) == SetUpProgress::kBusy) bus.deliver(device);
  const double set_points[] = {20000, 30000};
  const long before = allocationCount();
  for (int n = 0; n < 100; ++n) {
    device.writeSetPoints(set_points, Time{}, bus);
    device.request(Time{}, bus);
    bus.deliver(device);
    device.endCycle(Time{});
    bus.bench.pass(10);
  }
  EXPECT_EQ(allocationCount(), before);
  EXPECT_NEAR(device.readings()[1].measured, 30000, 450);
}

}  // namespace
}  // namespace sinew
