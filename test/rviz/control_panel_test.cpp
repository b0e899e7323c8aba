#include "control_panel.h"

#include <gtest/gtest.h>
#include <ros/ros.h>
#include <std_msgs/Bool.h>

#include <QApplication>
#include <chrono>
#include <functional>
#include <stdexcept>
#include <thread>
#include <vector>

// The panel without rviz around it and without a display.
namespace sinew {
namespace {

constexpr double kPatience = 10;  // s

class Panel : public testing::Test {
 protected:
  Panel() { panel_.initialize(nullptr); }

  void load(const char* name_space) {
    rviz::Config config;
    config.mapSetValue("Namespace", name_space);
    panel_.load(config);
  }

  QString saved() {
    rviz::Config config;
    panel_.save(config);
    QString name_space;
    EXPECT_TRUE(config.mapGetString("Namespace", &name_space));
    return name_space;
  }

  template <typename Widget>
  Widget& find(const char* name) {
    Widget* widget = panel_.findChild<Widget*>(name);
    if (!widget) throw std::runtime_error(name);
    return *widget;
  }

  QString driver() { return find<QLabel>("Driver").text(); }

  // Lets the panel live, publishing all the while, until `done`; returns whether it came to that.
  bool live(const std::function<bool()>& done, const ros::Publisher& publisher = {}, std::uint8_t state = 0) {
    ActuatorState message;
    message.driver_state = state;
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(kPatience);
    while (std::chrono::steady_clock::now() < end) {
      if (publisher) publisher.publish(message);
      QApplication::processEvents();
      ros::spinOnce();
      if (done()) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return false;
  }

  ros::Publisher advertise(const std::string& name_space) {
    return ros::NodeHandle(name_space).advertise<ActuatorState>("actuator_state", 1);
  }

  ControlPanel panel_;
};

TEST_F(Panel, listensInTheNamespaceOfRviz) {
  EXPECT_EQ(saved(), "");
  const ros::Publisher publisher = advertise("/robot");
  EXPECT_TRUE(live([&] { return driver() == "READY"; }, publisher, ActuatorState::READY)) << driver().toStdString();
}

TEST_F(Panel, forgetsOneRobotWhenItTurnsToAnother) {
  const ros::Publisher robot = advertise("/robot");
  ASSERT_TRUE(live([&] { return driver() == "READY"; }, robot, ActuatorState::READY));
  load("/other");
  EXPECT_TRUE(live([&] { return driver() == "NO DATA"; }, robot, ActuatorState::READY)) << driver().toStdString();
  const ros::Publisher other = advertise("/other");
  EXPECT_TRUE(live([&] { return driver() == "HOLDING"; }, other, ActuatorState::HOLDING)) << driver().toStdString();
  EXPECT_EQ(saved(), "/other");
}

TEST_F(Panel, showsSilence) {
  const ros::Publisher robot = advertise("/robot");
  ASSERT_TRUE(live([&] { return driver() == "ACTIVE"; }, robot, ActuatorState::ACTIVE));
  EXPECT_TRUE(find<QPushButton>("Halt").isEnabled());
  EXPECT_TRUE(live([&] { return driver() == "STALE"; }));
  EXPECT_FALSE(find<QPushButton>("Halt").isEnabled());
  EXPECT_TRUE(find<QPushButton>("EmergencyStop").isEnabled());
}

TEST_F(Panel, keepsItsNamespaceWhenTheNewOneIsNone) {
  load("/other");
  load("no namespace");
  EXPECT_EQ(saved(), "/other");
}

TEST_F(Panel, stopsTheRobotOfItsNamespaceUntilItIsLetGo) {
  load("/other");
  std::vector<bool> heard;
  const boost::function<void(const std_msgs::Bool::ConstPtr&)> note = [&](const std_msgs::Bool::ConstPtr& message) {
    heard.push_back(message->data != 0);
  };
  QPushButton& stop = find<QPushButton>("EmergencyStop");
  stop.click();
  const ros::Subscriber late = ros::NodeHandle("/other").subscribe<std_msgs::Bool>("emergency_stop", 10, note);
  EXPECT_TRUE(live([&] { return heard == std::vector<bool>{true}; })) << "latched, for a driver that starts later";
  EXPECT_FALSE(find<QLineEdit>("Namespace").isEnabled()) << "the stop would be left behind";
  stop.click();
  EXPECT_TRUE(live([&] { return heard == (std::vector<bool>{true, false}); }));
  EXPECT_TRUE(find<QLineEdit>("Namespace").isEnabled());
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  testing::InitGoogleTest(&argc, argv);
  qputenv("QT_QPA_PLATFORM", "offscreen");
  QApplication application(argc, argv);
  ros::init(argc, argv, "control_panel_test");
  ros::NodeHandle keep_running;
  return RUN_ALL_TESTS();
}
