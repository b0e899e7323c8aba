#include "sinew/hardware/emergency_stop_input.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/input.h>
#include <sys/stat.h>
#include <unistd.h>

#include <string>

namespace sinew {
namespace {

constexpr auto kSoon = std::chrono::milliseconds(20);

/// A pipe in place of the kernel's device: events written to it are read as a button's.
class EmergencyStopInputTest : public testing::Test {
 protected:
  EmergencyStopInputTest() : path_("/tmp/sinew_stop_" + std::to_string(getpid())), input_(path_) {
    unlink(path_.c_str());
  }
  ~EmergencyStopInputTest() override {
    unplug();
    unlink(path_.c_str());
  }

  void plug() {
    ASSERT_EQ(mkfifo(path_.c_str(), 0600), 0);
    button_ = open(path_.c_str(), O_RDWR | O_NONBLOCK);  // a reader of its own, so that it may be opened for writing
    ASSERT_GE(button_, 0);
  }
  void unplug() {
    if (button_ >= 0) close(button_);
    button_ = -1;
  }
  void send(std::uint16_t type, std::uint16_t code, std::int32_t value) {
    input_event event{};
    event.type = type;
    event.code = code;
    event.value = value;
    ASSERT_EQ(write(button_, &event, sizeof event), static_cast<ssize_t>(sizeof event));
    input_.update(kSoon);
  }

  std::string path_;
  EmergencyStopInput input_;
  int button_ = -1;
};

TEST_F(EmergencyStopInputTest, ADeviceThatIsNotThereIsAStop) {
  EXPECT_TRUE(input_.pressed());
  input_.update(kSoon);
  EXPECT_TRUE(input_.pressed());
  EXPECT_FALSE(input_.present());
}

TEST_F(EmergencyStopInputTest, AnyKeyThatIsDownIsAStopUntilAllAreUp) {
  plug();
  input_.update(kSoon);
  ASSERT_TRUE(input_.present());
  EXPECT_FALSE(input_.pressed());
  send(EV_KEY, KEY_ENTER, 1);
  EXPECT_TRUE(input_.pressed());
  send(EV_KEY, BTN_TRIGGER, 1);
  send(EV_KEY, KEY_ENTER, 0);
  EXPECT_TRUE(input_.pressed()) << "the other one is still down";
  send(EV_KEY, BTN_TRIGGER, 2);
  EXPECT_TRUE(input_.pressed()) << "a key that repeats is down";
  send(EV_KEY, BTN_TRIGGER, 0);
  EXPECT_FALSE(input_.pressed());
}

TEST_F(EmergencyStopInputTest, OtherEventsMeanNothing) {
  plug();
  input_.update(kSoon);
  send(EV_SYN, SYN_REPORT, 0);
  send(EV_REL, REL_X, 5);
  EXPECT_FALSE(input_.pressed());
}

TEST_F(EmergencyStopInputTest, UnpluggingIsAStop) {
  plug();
  input_.update(kSoon);
  ASSERT_FALSE(input_.pressed());
  unplug();
  input_.update(kSoon);
  EXPECT_TRUE(input_.pressed());
  EXPECT_FALSE(input_.present());
}

TEST_F(EmergencyStopInputTest, HalfAnEventIsABrokenDevice) {
  plug();
  input_.update(kSoon);
  ASSERT_EQ(write(button_, "half", 4), 4);
  input_.update(kSoon);
  EXPECT_TRUE(input_.pressed());
}

}  // namespace
}  // namespace sinew
