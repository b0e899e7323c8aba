#include "sinew/hardware/bus_group.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew {
namespace {

/// A bus that does what it is told, and notes it.
class NotingBus : public DeviceBus {
 public:
  explicit NotingBus(int size) : readings_(static_cast<std::size_t>(size)) {}
  int size() const override { return static_cast<int>(readings_.size()); }
  bool open(std::string& why) override {
    why = "no such port";
    return is_open = plugged;
  }
  void close() override { is_open = false; }
  bool isOpen() const override { return is_open; }
  void startSetUp(bool /*home_all*/) override { left = set_up_cycles; }
  SetUpProgress updateSetUp(Time /*now*/) override {
    if (broken) return SetUpProgress::kFailed;
    return --left > 0 ? SetUpProgress::kBusy : SetUpProgress::kDone;
  }
  bool writeSetPoints(const double* set_points, Time /*now*/) override {
    written.assign(set_points, set_points + size());
    ++writes;
    return plugged;
  }
  bool read(Time /*now*/) override {
    for (ActuatorReading& r : readings_) r.valid = plugged;
    for (std::size_t i = 0; i < written.size(); ++i) readings_[i].measured = written[i];
    return plugged;
  }
  bool relax(const std::vector<bool>& which, double s) override {
    relaxed = which;
    share = s;
    return plugged;
  }
  bool switchOff(const std::vector<bool>& which) override {
    switched_off = which;
    return plugged;
  }
  void setZero(int i, double displacement) override {
    readings_[static_cast<std::size_t>(i)].measured = displacement;
    readings_[static_cast<std::size_t>(i)].zero_valid = true;
  }
  const std::vector<ActuatorReading>& readings() const override { return readings_; }
  std::string faultDetail(int i) const override { return std::to_string(i); }
  const std::string& problem() const override { return problem_; }
  const BusCounters& counters() const override { return counted; }

  bool plugged = true, is_open = false, broken = false;
  int set_up_cycles = 3, left = 0, writes = 0;
  std::vector<double> written;
  std::vector<bool> relaxed, switched_off;
  double share = -1;
  BusCounters counted;

 private:
  std::vector<ActuatorReading> readings_;
  std::string problem_ = "pump (id 3) does not answer";
};

/// Actuators 0 and 2 on one bus, 1 on another.
struct Bench {
  Bench() {
    std::vector<BusGroup::Member> members;
    for (const std::vector<int>& actuators : {std::vector<int>{0, 2}, std::vector<int>{1}}) {
      auto bus = std::make_unique<NotingBus>(static_cast<int>(actuators.size()));
      buses.push_back(bus.get());
      members.push_back({std::move(bus), buses.size() == 1 ? "servos" : "pumps", actuators});
    }
    group = std::make_unique<BusGroup>(std::move(members));
  }
  bool open() {
    std::string why;
    return group->open(why);
  }
  bool exchange(const std::vector<double>& values) {
    return group->writeSetPoints(values.data(), Time{}) && group->read(Time{});
  }
  std::vector<NotingBus*> buses;
  std::unique_ptr<BusGroup> group;
};

TEST(BusGroup, EveryActuatorHasItsPlace) {
  Bench b;
  ASSERT_TRUE(b.open());
  ASSERT_TRUE(b.exchange({1, 2, 3}));
  EXPECT_EQ(b.buses[0]->written, std::vector<double>({1, 3}));
  EXPECT_EQ(b.buses[1]->written, std::vector<double>({2}));
  EXPECT_EQ(b.group->size(), 3);
  for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(b.group->readings()[i].measured, static_cast<double>(i + 1));
  EXPECT_EQ(b.group->faultDetail(2), "1");
  b.group->setZero(2, 7);
  EXPECT_EQ(b.group->readings()[2].measured, 7);
  EXPECT_TRUE(b.group->readings()[2].zero_valid);
  b.buses[0]->counted.missing = 2;
  b.buses[1]->counted.missing = 3;
  b.group->read(Time{});
  EXPECT_EQ(b.group->counters().missing, 5u);
}

TEST(BusGroup, ABusThatIsReadyEarlyIsServedWhileOthersAreSetUp) {
  Bench b;
  ASSERT_TRUE(b.open());
  b.buses[0]->set_up_cycles = 1;
  b.buses[1]->set_up_cycles = 5;
  b.group->startSetUp(true);
  for (int n = 0; n < 4; ++n) EXPECT_EQ(b.group->updateSetUp(Time{}), SetUpProgress::kBusy);
  EXPECT_EQ(b.group->updateSetUp(Time{}), SetUpProgress::kDone);
  EXPECT_EQ(b.buses[0]->writes, 4);
  EXPECT_EQ(b.buses[0]->written, std::vector<double>({0, 0})) << "where it was found";
}

TEST(BusGroup, AFailedSetUpIsToldInTheWordsOfItsBus) {
  Bench b;
  ASSERT_TRUE(b.open());
  b.buses[1]->broken = true;
  b.group->startSetUp(true);
  EXPECT_EQ(b.group->updateSetUp(Time{}), SetUpProgress::kFailed);
  EXPECT_EQ(b.group->problem(), "pump (id 3) does not answer");
}

TEST(BusGroup, ALostLineIsNamedAndTakesNothingFromTheOthers) {
  Bench b;
  ASSERT_TRUE(b.open());
  ASSERT_TRUE(b.exchange({1, 2, 3}));
  b.buses[0]->plugged = false;
  EXPECT_FALSE(b.exchange({4, 5, 6}));
  EXPECT_EQ(b.group->problem(), "the line of servos is gone");
  EXPECT_EQ(b.buses[1]->written, std::vector<double>({5}));
  EXPECT_FALSE(b.group->readings()[0].valid);
  EXPECT_TRUE(b.group->isOpen());
  EXPECT_FALSE(b.group->relax({true, true, true}, 0.5));
  EXPECT_EQ(b.buses[1]->share, 0.5);
  EXPECT_TRUE(b.buses[0]->relaxed.empty()) << "its line is gone";
  b.group->switchOff({false, true, false});
  EXPECT_EQ(b.buses[1]->switched_off, std::vector<bool>({true}));
}

TEST(BusGroup, OpensWhatIsClosedAndSaysWhatStaysSo) {
  Bench b;
  b.buses[1]->plugged = false;
  std::string why;
  EXPECT_FALSE(b.group->open(why));
  EXPECT_EQ(why, "pumps: no such port");
  EXPECT_TRUE(b.buses[0]->is_open);
  b.buses[1]->plugged = true;
  EXPECT_TRUE(b.group->open(why));
}

}  // namespace
}  // namespace sinew
