// The timed scenes that stand beside those of the method's thesis: as large, solved in every cycle, and lawful.

#include "robot_scene.h"

#include <gtest/gtest.h>

#include <memory>
#include <stdexcept>
#include <string>

#include "inverse/contact_checks.h"
#include "measuring.h"
#include "sinew/robot/robot_description.h"
#include "timed_robot.h"

namespace sinew {
namespace {

struct ThesisScene {
  const char* name;
  int unknowns, contacts;  // contacts: on average
  double seconds;          // of ours that see all there is
};

constexpr ThesisScene kThesis[] = {
    {"trunk_contact", 1665, 76, 4}, {"finger_contact", 474, 5, 8}, {"beam_contact", 480, 19, 16}};

RobotScene findScene(const std::string& name) {
  for (const RobotScene& scene : makeRobotScenes(SINEW_SOURCE_DIR)) {
    if (scene.name == name) return scene;
  }
  throw std::runtime_error("no scene " + name);
}

class RobotSceneTest : public testing::TestWithParam<ThesisScene> {};

TEST_P(RobotSceneTest, isAsLargeAsTheThesisOne) {
  RobotScene scene = findScene(GetParam().name);
  scene.duration = GetParam().seconds;
  const auto robot = std::make_shared<const RobotModel>(readRobotDescription(scene.file));
  EXPECT_NEAR(robot->fem().size(), GetParam().unknowns, 0.06 * GetParam().unknowns);
  EXPECT_EQ(scene.thesis.count("cycle"), 1u);

  InverseController controller(robot);
  ContactWatch watch(controller);
  ContactCounts counts;
  runController(scene, controller, [&](int cycle, const CycleInput& input, const CycleOutput& output) {
    EXPECT_FALSE(output.contacts.crowded) << "cycle " << cycle;
    if (cycle < 0 || cycle % 4 != 0) return;
    watch.add(input, output);
    counts.add(output.contacts);
  });
  watch.check(scene.name, 0.0002);
  EXPECT_GE(calcMedian(counts.all), 0.9 * GetParam().contacts);
  EXPECT_GE(calcMedian(counts.pressing), 2);
}

INSTANTIATE_TEST_SUITE_P(All, RobotSceneTest, testing::ValuesIn(kThesis),
                         [](const auto& scene) { return std::string(scene.param.name); });

TEST(RobotScenes, fitTheirRobots) {
  for (const RobotScene& scene : makeRobotScenes(SINEW_SOURCE_DIR)) {
    const RobotDescription robot = readRobotDescription(scene.file);
    EXPECT_GE(scene.duration, 4) << scene.name;
    EXPECT_EQ(scene.target(0).size() % 3, 0) << scene.name;
    EXPECT_LE(scene.target(0).size(), 3 * static_cast<int>(robot.effectors.size())) << scene.name;
    const bool tracked = !robot.obstacles.empty() && robot.obstacles[0].tracked;
    EXPECT_TRUE(tracked || !scene.place_obstacles) << scene.name;
  }
}

}  // namespace
}  // namespace sinew
