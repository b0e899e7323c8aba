#include "sinew/hardware/can_device_bus.h"

#include <gtest/gtest.h>

#include <deque>
#include <map>

#include "hardware/can_frames.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

// A port whose other end is the test. Time passes while someone waits.
class ScriptedPort : public CanPort {
 public:
  StreamStatus send(const CanFrame& frame, Duration timeout) override {
    if (closed) return StreamStatus::kClosed;
    if (full) {
      now_ += timeout;
      return StreamStatus::kTimeout;
    }
    sent.push_back(frame);
    const auto answer = answers.find(frame.id);
    if (answer != answers.end()) arriving.push_back(answer->second);
    return StreamStatus::kOk;
  }
  StreamStatus receive(CanFrame& frame, Duration timeout) override {
    if (closed) return StreamStatus::kClosed;
    if (arriving.empty()) {
      now_ += timeout;
      return StreamStatus::kTimeout;
    }
    frame = arriving.front();
    arriving.pop_front();
    return StreamStatus::kOk;
  }
  std::uint64_t damaged() const override { return damaged_lines; }
  Time now() const override { return now_; }
  std::vector<std::uint32_t> takeSent() {
    std::vector<std::uint32_t> ids;
    for (const CanFrame& f : sent) ids.push_back(f.id);
    sent.clear();
    return ids;
  }

  std::vector<CanFrame> sent;
  std::deque<CanFrame> arriving;
  std::map<std::uint32_t, CanFrame> answers;  // to what is sent
  bool closed = false, full = false;
  std::uint64_t damaged_lines = 0;

 private:
  Time now_{std::chrono::seconds(1)};
};

// Sends its identifier for everything it is told, and takes frames of identifier + 1 with one byte a channel.
class FakeDevice : public CanDevice {
 public:
  FakeDevice(std::uint32_t id, int channels, bool sync) : id_(id), sync_(sync), readings_(unsigned(channels)) {}
  int size() const override { return static_cast<int>(readings_.size()); }
  bool wantsSync() const override { return sync_; }
  void startSetUp(bool home) override { home_all = home; }
  SetUpProgress updateSetUp(Time, CanSender& out) override {
    out.send(makeFrame(id_, {1}));
    if (fails) return SetUpProgress::kFailed;
    return --steps > 0 ? SetUpProgress::kBusy : SetUpProgress::kDone;
  }
  void writeSetPoints(const double* set_points, Time, CanSender& out) override {
    written.assign(set_points, set_points + size());
    out.send(makeFrame(id_, {2}));
  }
  void request(Time, CanSender& out) override {
    out.send(makeFrame(id_, {3}));
    awaits_ = true;
  }
  bool take(const CanFrame& frame, Time) override {
    if (frame.id != id_ + 1) return false;
    for (std::size_t i = 0; i < readings_.size(); ++i) readings_[i].measured = frame.data[i];
    awaits_ = false;
    return true;
  }
  bool complete() const override { return !awaits_; }
  void endCycle(Time) override {
    for (ActuatorReading& r : readings_) r.valid = !awaits_;
    if (awaits_) ++counters_.missing;
  }
  void relax(const bool* which, double share, CanSender&) override {
    relaxed.assign(which, which + size());
    relaxed_share = share;
  }
  void switchOff(const bool* which, CanSender& out) override {
    off.assign(which, which + size());
    out.send(makeFrame(id_, {4}));
  }
  void setZero(int i, double displacement) override {
    readings_[static_cast<std::size_t>(i)].measured = displacement;
    readings_[static_cast<std::size_t>(i)].zero_valid = true;
  }
  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override {
    return "channel " + std::to_string(i) + " of " + std::to_string(id_);
  }
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return counters_; }

  int steps = 1;
  bool fails = false, home_all = false;
  std::vector<double> written;
  std::vector<bool> relaxed, off;
  double relaxed_share = -1;

 private:
  std::uint32_t id_;
  bool sync_;
  bool awaits_ = false;
  std::vector<ActuatorReading> readings_;
  std::string problem_ = "the fake is broken";
  BusCounters counters_;
};

// Two devices, whose actuators take turns: 0 and 2 of the first, 1 of the second.
struct Bench {
  explicit Bench(bool sync = false) {
    auto a = std::make_unique<FakeDevice>(0x10, 2, false);
    auto b = std::make_unique<FakeDevice>(0x20, 1, sync);
    first = a.get();
    second = b.get();
    std::vector<CanDeviceBus::Member> members;
    members.push_back({std::move(a), {0, 2}});
    members.push_back({std::move(b), {1}});
    DeviceTiming timing;
    timing.reply_timeout = 0.002;
    bus = std::make_unique<CanDeviceBus>([this](std::string&) { return port; }, std::move(members), timing);
    std::string why;
    bus->open(why);
  }
  std::shared_ptr<ScriptedPort> port = std::make_shared<ScriptedPort>();
  FakeDevice *first = nullptr, *second = nullptr;
  std::unique_ptr<CanDeviceBus> bus;
  const double set_points[3] = {1, 2, 3};
};

TEST(CanDeviceBus, ActuatorsKeepTheirNumbers) {
  Bench b;
  ASSERT_TRUE(b.bus->writeSetPoints(b.set_points, b.port->now()));
  EXPECT_EQ(b.first->written, (std::vector<double>{1, 3}));
  EXPECT_EQ(b.second->written, (std::vector<double>{2}));
  b.port->arriving = {makeFrame(0x11, {7, 8}), makeFrame(0x21, {9})};
  ASSERT_TRUE(b.bus->read(b.port->now()));
  ASSERT_TRUE(b.bus->relax({true, false, false}, 0.5));
  EXPECT_EQ(b.first->relaxed, (std::vector<bool>{true, false}));
  EXPECT_EQ(b.first->relaxed_share, 0.5);
  EXPECT_TRUE(b.second->relaxed.empty());
  ASSERT_TRUE(b.bus->switchOff({false, true, true}));
  EXPECT_EQ(b.first->off, (std::vector<bool>{false, true}));
  EXPECT_EQ(b.second->off, (std::vector<bool>{true}));
  b.bus->setZero(2, 0.25);
  EXPECT_EQ(b.bus->readings()[2].measured, 0.25);
  EXPECT_TRUE(b.bus->readings()[2].zero_valid);
  EXPECT_FALSE(b.bus->readings()[0].zero_valid);
  EXPECT_EQ(b.bus->faultDetail(2), "channel 1 of 16");
}

TEST(CanDeviceBus, SyncEndsTheSetPointsWhereADeviceWantsIt) {
  Bench without(false), with(true);
  without.bus->writeSetPoints(without.set_points, without.port->now());
  EXPECT_EQ(without.port->takeSent(), (std::vector<std::uint32_t>{0x10, 0x20}));
  with.bus->writeSetPoints(with.set_points, with.port->now());
  ASSERT_EQ(with.port->sent.size(), 3u);
  EXPECT_TRUE(with.port->sent.back() == makeFrame(0x080, {}));
}

TEST(CanDeviceBus, ReadWaitsUntilAllHaveComeAndNoLonger) {
  Bench b;
  const auto readFor = [&b] {
    const Time start = b.port->now();
    EXPECT_TRUE(b.bus->read(start));
    return seconds(b.port->now() - start);
  };
  EXPECT_NEAR(readFor(), 0.002, 1e-9) << "nobody answers";
  EXPECT_FALSE(b.bus->readings()[0].valid);
  EXPECT_EQ(b.bus->counters().missing, 2u);
  b.port->answers[0x10] = makeFrame(0x11, {7, 8});
  EXPECT_NEAR(readFor(), 0.002, 1e-9) << "one does not answer";
  EXPECT_TRUE(b.bus->readings()[0].valid);
  EXPECT_FALSE(b.bus->readings()[1].valid);
  b.port->answers[0x20] = makeFrame(0x21, {9});
  EXPECT_EQ(readFor(), 0);
  EXPECT_TRUE(b.bus->readings()[1].valid);
  EXPECT_EQ(b.bus->counters().missing, 3u);
}

TEST(CanDeviceBus, EveryFrameIsShownToAllAndCounted) {
  Bench b;
  b.port->arriving = {makeFrame(0x11, {7, 8}), makeFrame(0x700, {0}), makeFrame(0x21, {9})};
  b.bus->read(b.port->now());
  EXPECT_EQ(b.bus->received(), 3u);
  EXPECT_EQ(b.bus->strangers(), 1u);
  EXPECT_EQ(b.bus->counters().stale, 1u);
  EXPECT_EQ(b.bus->readings()[0].measured, 7);
  EXPECT_EQ(b.bus->readings()[1].measured, 9);
  EXPECT_EQ(b.bus->readings()[2].measured, 8);
}

TEST(CanDeviceBus, WhatThePortCountsOutlivesItsClosing) {
  Bench b;
  b.port->damaged_lines = 3;
  b.bus->read(b.port->now());
  EXPECT_EQ(b.bus->counters().corrupted, 3u);
  b.bus->close();
  b.port = std::make_shared<ScriptedPort>();
  b.port->damaged_lines = 2;
  std::string why;
  ASSERT_TRUE(b.bus->open(why));
  b.bus->read(b.port->now());
  EXPECT_EQ(b.bus->counters().corrupted, 5u);
}

TEST(CanDeviceBus, ABusFullOfStrangersDoesNotHoldItUp) {
  Bench b;
  for (int n = 0; n < 100000; ++n) b.port->arriving.push_back(makeFrame(0x7FF, {}));
  b.bus->writeSetPoints(b.set_points, b.port->now());
  EXPECT_GT(b.port->arriving.size(), 90000u);
}

TEST(CanDeviceBus, WhoIsReadyHoldsUntilAllAre) {
  Bench b(true);
  b.first->steps = 1;
  b.second->steps = 4;
  b.bus->startSetUp(true);
  EXPECT_TRUE(b.first->home_all && b.second->home_all);
  b.port->arriving = {makeFrame(0x11, {7, 8})};
  EXPECT_EQ(b.bus->updateSetUp(b.port->now()), SetUpProgress::kBusy);
  EXPECT_EQ(b.port->takeSent(), (std::vector<std::uint32_t>{0x10, 0x20}));
  EXPECT_EQ(b.bus->updateSetUp(b.port->now()), SetUpProgress::kBusy);
  EXPECT_EQ(b.first->written, (std::vector<double>{7, 8})) << "where it was found";
  EXPECT_EQ(b.port->takeSent(), (std::vector<std::uint32_t>{0x10, 0x20, 0x080}));
  EXPECT_EQ(b.bus->updateSetUp(b.port->now()), SetUpProgress::kBusy);
  EXPECT_EQ(b.bus->updateSetUp(b.port->now()), SetUpProgress::kDone);
}

TEST(CanDeviceBus, TheFirstThatFailsSaysWhy) {
  Bench b;
  b.second->fails = true;
  b.first->steps = 100;
  b.bus->startSetUp(false);
  EXPECT_EQ(b.bus->updateSetUp(b.port->now()), SetUpProgress::kFailed);
  EXPECT_EQ(b.bus->problem(), "the fake is broken");
  b.second->fails = false;
  b.first->steps = 1;
  b.bus->startSetUp(false);
  EXPECT_EQ(b.bus->updateSetUp(b.port->now()), SetUpProgress::kDone);
  EXPECT_EQ(b.bus->problem(), "");
}

TEST(CanDeviceBus, AFullBusCostsNoMoreThanTheReplyTimeout) {
  Bench b;
  b.port->full = true;
  const Time start = b.port->now();
  EXPECT_TRUE(b.bus->writeSetPoints(b.set_points, start));
  EXPECT_NEAR(seconds(b.port->now() - start), 0.002, 1e-9);
  EXPECT_EQ(b.bus->unsent(), 2u);
}

TEST(CanDeviceBus, SaysWhenTheLineIsGone) {
  Bench b;
  b.port->closed = true;
  EXPECT_FALSE(b.bus->writeSetPoints(b.set_points, b.port->now()));
  EXPECT_FALSE(b.bus->read(b.port->now()));
  EXPECT_FALSE(b.bus->relax({true, true, true}, 1) && b.bus->switchOff({true, true, true}));
  b.bus->startSetUp(false);
  EXPECT_EQ(b.bus->updateSetUp(b.port->now()), SetUpProgress::kFailed);
  EXPECT_NE(b.bus->problem().find("gone"), std::string::npos);
  b.port->closed = false;
  std::string why;
  b.bus->close();
  EXPECT_FALSE(b.bus->isOpen());
  EXPECT_FALSE(b.bus->read(b.port->now()));
  ASSERT_TRUE(b.bus->open(why));
  EXPECT_TRUE(b.bus->read(b.port->now()));
}

TEST(CanDeviceBus, SaysWhyItCannotOpen) {
  DeviceTiming timing;
  CanDeviceBus bus(
      [](std::string& why) -> std::shared_ptr<CanPort> {
        why = "no such interface";
        return nullptr;
      },
      {}, timing);
  std::string why;
  EXPECT_FALSE(bus.open(why));
  EXPECT_EQ(why, "no such interface");
}

TEST(CanDeviceBus, RefusesActuatorsThatAreNotNumberedOnce) {
  for (const std::vector<int>& numbers :
       {std::vector<int>{0, 0}, std::vector<int>{0, 2}, std::vector<int>{0}, std::vector<int>{-1, 0}}) {
    std::vector<CanDeviceBus::Member> members;
    members.push_back({std::make_unique<FakeDevice>(0x10, 2, false), numbers});
    EXPECT_THROW(CanDeviceBus(nullptr, std::move(members), DeviceTiming()), ConfigError);
  }
}

}  // namespace
}  // namespace sinew
