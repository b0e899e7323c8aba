#include "sinew/robot/robot_description.h"

#include <gtest/gtest.h>

#include "common/complaint.h"
#include "robot/temporary_folder.h"

namespace sinew {
namespace {

constexpr const char* kYaml = R"(name: arm
frame: arm_frame
urdf: arm.urdf
mesh: {file: meshes/arm.msh, scale: 0.001}
gravity: {vector: [0, 0, -9.81], frame: world}
materials:
  - {region: 4, young_modulus: 2.5e+5, poisson_ratio: 0.45, density: 1080}
  - {young_modulus: 1.0e+6, poisson_ratio: 0.3, total_mass: 0.25}
damping: {mass: 2, stiffness: 0.02}
fixed:
  boxes: [{min: [-1, -2, -3], max: [1, 2, 3]}]
  spheres: [{centre: [4, 5, 6], radius: 0.5}]
  nodes: [7, 8]
effectors:
  - {name: tip, point: [0, 0, 0.2], axes: [x, z], weight: 2.5, hold: true}
  - {name: middle, point: [0, 0, 0.1]}
cables:
  - name: left
    pull_point: [0.01, 0, 0]
    via_points: [[0.01, 0, 0.1], [0.01, 0, 0.2]]
    displacement: {min: -0.01, max: 0.05, rate: 0.1}
    tension: {min: 1, max: 20, rate: 40}
    tube_stiffness: 300
  - name: right
    pull_point: [-0.01, 0, 0]
    via_points: [[-0.01, 0, 0.2]]
carrier: {name: rail, axis: [0, 0, 2], displacement: {min: -0.1, max: 0.2, rate: 0.05}}
control: {model: dynamic, newton_steps: 3, max_node_step: 0.02, reach_per_cycle: 0.03, smoothing: 0.1,
          max_pieces: 30, max_nodes: 0, search_time: 0.002, switching_margin: 0.1, switching_reach: 0.004}
obstacles:
  - {name: floor, plane: {point: [0, 0, 0.3], normal: [0, 0, -2]}}
  - {name: post, link: post, tracked: true}
contacts: {method: volume, alarm_distance: 0.004, contact_distance: 0.002, self: true, max_contacts: 7, resolution: 32}
)";

// The robot hangs: its frame is turned by pi about x.
constexpr const char* kUrdf = R"(<robot name="arm"><link name="world"/><link name="arm_frame"/>
  <joint name="hang" type="fixed"><parent link="world"/><child link="arm_frame"/>
    <origin xyz="0 0 1" rpy="3.14159265358979 0 0"/></joint>
  <link name="post"><collision><geometry><cylinder radius="0.02" length="0.5"/></geometry></collision></link>
  <joint name="stands" type="fixed"><parent link="world"/><child link="post"/><origin xyz="0.3 0 0"/></joint>
  </robot>)";

std::string replaced(const std::string& text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return at == std::string::npos ? text : std::string(text).replace(at, from.size(), to);
}

class RobotDescriptionTest : public testing::Test {
 protected:
  TemporaryFolder folder;

  RobotDescriptionTest() { folder.write("arm.urdf", kUrdf); }

  RobotDescription read(const std::string& text) const { return readRobotDescription(folder.write("arm.yaml", text)); }

  RobotDescription readWith(const std::string& from, const std::string& to) const {
    return read(replaced(kYaml, from, to));
  }
};

TEST_F(RobotDescriptionTest, ReadsWhatItIsMadeOf) {
  const RobotDescription robot = read(kYaml);
  EXPECT_EQ(robot.name, "arm");
  EXPECT_EQ(robot.file, folder.path() + "/arm.yaml");
  EXPECT_EQ(robot.mesh_file, folder.path() + "/meshes/arm.msh");
  EXPECT_EQ(robot.mesh_scale, 0.001);
  EXPECT_EQ(robot.urdf_file, folder.path() + "/arm.urdf");
  EXPECT_EQ(robot.frame, "arm_frame");
  EXPECT_EQ(robot.damping_mass, 2);
  EXPECT_EQ(robot.damping_stiffness, 0.02);
  ASSERT_EQ(robot.materials.size(), 2U);
  EXPECT_EQ(robot.materials[0].region, 4);
  EXPECT_EQ(robot.materials[0].young_modulus, 2.5e5);
  EXPECT_EQ(robot.materials[0].poisson_ratio, 0.45);
  EXPECT_EQ(robot.materials[0].density, 1080);
  EXPECT_EQ(robot.materials[0].total_mass, 0);
  EXPECT_EQ(robot.materials[1].region, -1);
  EXPECT_EQ(robot.materials[1].density, 0);
  EXPECT_EQ(robot.materials[1].total_mass, 0.25);
  ASSERT_EQ(robot.fixed.boxes.size(), 1U);
  EXPECT_EQ(robot.fixed.boxes[0].min, Vec3(-1, -2, -3));
  EXPECT_EQ(robot.fixed.boxes[0].max, Vec3(1, 2, 3));
  ASSERT_EQ(robot.fixed.spheres.size(), 1U);
  EXPECT_EQ(robot.fixed.spheres[0].centre, Vec3(4, 5, 6));
  EXPECT_EQ(robot.fixed.spheres[0].radius, 0.5);
  EXPECT_EQ(robot.fixed.nodes, (std::vector<int>{7, 8}));
}

TEST_F(RobotDescriptionTest, ReadsCablesEffectorsAndControl) {
  const RobotDescription robot = read(kYaml);
  ASSERT_EQ(robot.cables.size(), 2U);
  const CableDescription& left = robot.cables[0];
  EXPECT_EQ(left.name, "left");
  EXPECT_EQ(left.pull_point, Vec3(0.01, 0, 0));
  EXPECT_EQ(left.via_points, (std::vector<Vec3>{Vec3(0.01, 0, 0.1), Vec3(0.01, 0, 0.2)}));
  EXPECT_EQ(left.displacement.min, -0.01);
  EXPECT_EQ(left.displacement.max, 0.05);
  EXPECT_EQ(left.displacement.rate, 0.1);
  EXPECT_EQ(left.tension.min, 1);
  EXPECT_EQ(left.tension.max, 20);
  EXPECT_EQ(left.tension.rate, 40);
  EXPECT_EQ(left.tube_stiffness, 300);
  ASSERT_EQ(robot.effectors.size(), 2U);
  EXPECT_EQ(robot.effectors[0].name, "tip");
  EXPECT_EQ(robot.effectors[0].point, Vec3(0, 0, 0.2));
  EXPECT_EQ(robot.effectors[0].axes, (std::array<bool, 3>{{true, false, true}}));
  EXPECT_EQ(robot.effectors[0].weight, 2.5);
  EXPECT_TRUE(robot.effectors[0].hold);
  EXPECT_FALSE(robot.effectors[1].hold);
  EXPECT_EQ(robot.control.model, MotionModel::kDynamic);
  EXPECT_EQ(robot.control.newton_steps, 3);
  EXPECT_EQ(robot.control.max_node_step, 0.02);
  EXPECT_EQ(robot.control.reach_per_cycle, 0.03);
  EXPECT_EQ(robot.control.smoothing, 0.1);
  EXPECT_EQ(robot.control.max_pieces, 30);
  EXPECT_EQ(robot.control.max_nodes, 0);
  EXPECT_EQ(robot.control.search_time, 0.002);
  EXPECT_EQ(robot.control.switching_margin, 0.1);
  EXPECT_EQ(robot.control.switching_reach, 0.004);
}

TEST_F(RobotDescriptionTest, ListsTheCarrierBehindTheCables) {
  const RobotDescription robot = readRobotDescription(folder.write("arm.yaml", kYaml));
  EXPECT_EQ(robot.carrier.axis, Vec3(0, 0, 2));
  const std::vector<ActuatorLimits> actuators = listActuators(robot);
  ASSERT_EQ(actuators.size(), 3U);
  EXPECT_EQ(actuators[0].name, "left");
  EXPECT_EQ(actuators[0].effort.max, 20);
  EXPECT_EQ(actuators[2].name, "rail");
  EXPECT_EQ(actuators[2].displacement.max, 0.2);
  EXPECT_EQ(actuators[2].displacement.rate, 0.05);
  EXPECT_EQ(actuators[2].effort.max, kUnlimited);
}

TEST_F(RobotDescriptionTest, LeavesOutWhatMayBeLeftOut) {
  std::string text = kYaml;
  for (const char* line : {"frame: arm_frame\n", "urdf: arm.urdf\n", "damping: {mass: 2, stiffness: 0.02}\n",
                           ", frame: world", ", scale: 0.001"}) {
    text = replaced(text, line, "");
  }
  text = replaced(
      text, "fixed:\n  boxes: [{min: [-1, -2, -3], max: [1, 2, 3]}]\n  spheres: [{centre: [4, 5, 6], radius: 0.5}]\n",
      "fixed:\n");
  text.erase(text.find("control:"));
  const RobotDescription robot = read(text);
  EXPECT_EQ(robot.frame, "arm_base");
  EXPECT_EQ(robot.urdf_file, "");
  EXPECT_EQ(robot.gravity, Vec3(0, 0, -9.81));
  EXPECT_EQ(robot.mesh_scale, 1);
  EXPECT_EQ(robot.damping_mass, 0);
  EXPECT_EQ(robot.fixed.nodes.size(), 2U);
  EXPECT_EQ(robot.control.model, MotionModel::kStatic);
  EXPECT_EQ(robot.control.newton_steps, 1);
  EXPECT_EQ(robot.control.search_time, 0) << "the counts alone";
  EXPECT_EQ(robot.control.switching_reach, kUnlimited);
  const CableDescription& right = robot.cables[1];
  EXPECT_EQ(right.displacement.min, -kUnlimited);
  EXPECT_EQ(right.displacement.max, kUnlimited);
  EXPECT_EQ(right.displacement.rate, kUnlimited);
  EXPECT_EQ(right.tension.min, 0) << "a cable pulls only";
  EXPECT_EQ(right.tension.max, kUnlimited);
  EXPECT_EQ(right.tube_stiffness, 0);
  EXPECT_EQ(robot.effectors[1].axes, (std::array<bool, 3>{{true, true, true}}));
  EXPECT_EQ(robot.effectors[1].weight, 1);
}

TEST_F(RobotDescriptionTest, TurnsGravityIntoTheFrameOfAHangingRobot) {
  EXPECT_LT((read(kYaml).gravity - Vec3(0, 0, 9.81)).norm(), 1e-12);
  EXPECT_LT((readWith("[0, 0, -9.81]", "[1, 2, 3]").gravity - Vec3(1, -2, -3)).norm(), 1e-12);
  EXPECT_EQ(readWith("frame: world", "frame: arm_frame").gravity, Vec3(0, 0, -9.81));
}

struct Mistake {
  const char* from;
  const char* to;
  const char* complaint;  ///< after the name of the file
};

void PrintTo(const Mistake& mistake, std::ostream* out) {
  *out << "'" << mistake.from << "' -> '" << mistake.to << "'";
}

class RobotMistake : public RobotDescriptionTest, public testing::WithParamInterface<Mistake> {};

TEST_P(RobotMistake, IsNamedInFull) {
  const Mistake& mistake = GetParam();
  const std::string complaint = complaintOf([&] { readWith(mistake.from, mistake.to); });
  EXPECT_EQ(complaint.find(folder.path() + "/arm.yaml: " + mistake.complaint), 0U) << complaint;
}

INSTANTIATE_TEST_SUITE_P(
    Missing, RobotMistake,
    testing::Values(Mistake{"name: arm\n", "", "name: found nothing, expected a text"},
                    Mistake{"mesh: {", "mash: {", "mesh: found nothing, expected a mapping"},
                    Mistake{"file: meshes/arm.msh, ", "", "mesh.file: found nothing"},
                    Mistake{"gravity: {", "gravty: {", "gravity: found nothing, expected a mapping"},
                    Mistake{"vector: [0, 0, -9.81], ", "", "gravity.vector: found nothing, expected [x, y, z]"},
                    Mistake{"materials:", "material:", "materials: found nothing, expected a list of one material"},
                    Mistake{"young_modulus: 1.0e+6, ", "", "materials[1].young_modulus: found nothing"},
                    Mistake{", poisson_ratio: 0.45", "", "materials[0].poisson_ratio: found nothing"},
                    Mistake{", density: 1080", "", "materials[0].density: found nothing, expected either density"},
                    Mistake{"fixed:", "fixd:", "fixed: found nothing, expected a mapping"},
                    Mistake{"min: [-1, -2, -3], ", "", "fixed.boxes[0].min: found nothing"},
                    Mistake{", radius: 0.5", "", "fixed.spheres[0].radius: found nothing"},
                    Mistake{"effectors:", "effector:", "effectors: found nothing, expected a list of one effector"},
                    Mistake{"name: middle, ", "", "effectors[1].name: found nothing"},
                    Mistake{"point: [0, 0, 0.2], ", "", "effectors[0].point: found nothing"},
                    Mistake{"cables:", "cable:", "cables: found nothing, expected a list of one cable"},
                    Mistake{"name: left\n    ", "", "cables[0].name: found nothing"},
                    Mistake{"    pull_point: [-0.01, 0, 0]\n", "", "cables[1].pull_point: found nothing"},
                    Mistake{"    via_points: [[-0.01, 0, 0.2]]\n", "", "cables[1].via_points: found nothing"}));

INSTANTIATE_TEST_SUITE_P(
    Wrong, RobotMistake,
    testing::Values(
        Mistake{"scale: 0.001", "scale: 0", "mesh.scale: found '0', expected a number > 0"},
        Mistake{"[0, 0, -9.81]", "[0, 0, -9810]", "gravity.vector: found [0, 0, -9810], expected an acceleration"},
        Mistake{"urdf: arm.urdf\n", "", "gravity.frame: found 'world', expected 'arm_frame', or a link of a URDF"},
        Mistake{"young_modulus: 2.5e+5", "young_modulus: -1", "materials[0].young_modulus: found '-1'"},
        Mistake{"young_modulus: 2.5e+5", "young_modulus: .inf", "materials[0].young_modulus: found '.inf'"},
        Mistake{"ratio: 0.45", "ratio: 0.5", "materials[0].poisson_ratio: found '0.5', expected a number from -0.99"},
        Mistake{"density: 1080", "density: -2", "materials[0].density: found '-2'"},
        Mistake{"density: 1080", "density: 1080, total_mass: 1", "materials[0].density: found '1080', expected either"},
        Mistake{"total_mass: 0.25", "total_mass: 0", "materials[1].total_mass: found '0'"},
        Mistake{"region: 4", "region: -4", "materials[0].region: found '-4'"},
        Mistake{"- {young_modulus: 1", "- {region: 4, young_modulus: 1",
                "materials[1].region: found '4', expected each"},
        Mistake{"mass: 2, ", "mass: -2, ", "damping.mass: found '-2', expected a number >= 0"},
        Mistake{"stiffness: 0.02", "stiffness: x", "damping.stiffness: found 'x'"},
        Mistake{"max: [1, 2, 3]", "max: [1, -3, 3]", "fixed.boxes[0].max: found [1, -3, 3], expected no coordinate"},
        Mistake{"radius: 0.5", "radius: -1", "fixed.spheres[0].radius: found '-1'"},
        Mistake{"nodes: [7, 8]", "nodes: [7, -8]", "fixed.nodes[1]: found '-8'"},
        Mistake{"name: middle", "name: tip", "effectors[1].name: found 'tip', expected a name used once"},
        Mistake{"axes: [x, z]", "axes: [x, w]", "effectors[0].axes: found [x, w], expected a list of x, y, z"},
        Mistake{"axes: [x, z]", "axes: []", "effectors[0].axes: found []"},
        Mistake{"weight: 2.5", "weight: 0", "effectors[0].weight: found '0', expected a number > 0"}));

INSTANTIATE_TEST_SUITE_P(
    WrongCables, RobotMistake,
    testing::Values(
        Mistake{"name: right", "name: left", "cables[1].name: found 'left', expected a name used once"},
        Mistake{"[[-0.01, 0, 0.2]]", "[]", "cables[1].via_points: found [], expected one point or more"},
        Mistake{"[[-0.01, 0, 0.2]]", "[[-0.01, 0]]", "cables[1].via_points[0]: found [-0.01, 0], expected [x, y, z]"},
        Mistake{"min: -0.01", "min: 0.01", "cables[0].displacement.min: found '0.01', expected a number <= 0"},
        Mistake{"max: 0.05", "max: -0.001", "cables[0].displacement.max: found '-0.001', expected a number >= 0"},
        Mistake{"max: 0.05", "max: -1", "cables[0].displacement.max: found '-1', expected a number >= min"},
        Mistake{"rate: 0.1", "rate: 0", "cables[0].displacement.rate: found '0', expected a number > 0"},
        Mistake{"min: 1, max: 20", "min: 30, max: 20", "cables[0].tension.max: found '20', expected a number >= min"},
        Mistake{"rate: 40", "rate: -40", "cables[0].tension.rate: found '-40', expected a number >= 0"},
        Mistake{"tube_stiffness: 300", "tube_stiffness: -1", "cables[0].tube_stiffness: found '-1'"},
        Mistake{"model: dynamic", "model: fast", "control.model: found 'fast', expected one of static, dynamic"},
        Mistake{"newton_steps: 3", "newton_steps: 0", "control.newton_steps: found '0'"},
        Mistake{"search_time: 0.002", "search_time: -1", "control.search_time: found '-1'"},
        Mistake{"switching_margin: 0.1", "switching_margin: 2", "control.switching_margin: found '2'"},
        Mistake{"switching_reach: 0.004", "switching_reach: -1", "control.switching_reach: found '-1'"},
        Mistake{"node_step: 0.02", "node_step: 0", "control.max_node_step: found '0'"},
        Mistake{"reach_per_cycle: 0.03", "reach_per_cycle: -1", "control.reach_per_cycle: found '-1'"},
        Mistake{"smoothing: 0.1", "smoothing: -1", "control.smoothing: found '-1'"}));

INSTANTIATE_TEST_SUITE_P(
    WrongCarrier, RobotMistake,
    testing::Values(
        Mistake{"name: rail, ", "", "carrier.name: found nothing"},
        Mistake{"name: rail", "name: left", "carrier.name: found 'left', expected a name that no cable has"},
        Mistake{"axis: [0, 0, 2]", "axis: [0, 0, 0]", "carrier.axis: found [0, 0, 0], expected the direction"},
        Mistake{"min: -0.1, ", "min: 0.1, ", "carrier.displacement.min: found '0.1', expected a number <= 0"},
        Mistake{"rate: 0.05", "rat: 0.05", "carrier.displacement.rat: found an unknown key"}));

INSTANTIATE_TEST_SUITE_P(
    WrongObstacles, RobotMistake,
    testing::Values(
        Mistake{"name: post", "name: floor", "obstacles[1].name: found 'floor', expected a name used once"},
        Mistake{"link: post, ", "", "obstacles[1].link: found nothing, expected either link"},
        Mistake{"normal: [0, 0, -2]", "normal: [0, 0, 0]", "obstacles[0].plane.normal: found [0, 0, 0], expected the"},
        Mistake{"tracked: true", "traced: true", "obstacles[1].traced: found an unknown key"},
        Mistake{"method: volume", "method: guess", "contacts.method: found 'guess', expected one of proximity, volume"},
        Mistake{"alarm_distance: 0.004", "alarm_distance: 0", "contacts.alarm_distance: found '0'"},
        Mistake{"contact_distance: 0.002", "contact_distance: 0.004", "contacts.contact_distance: found '0.004'"},
        Mistake{"contact_distance: 0.002", "contact_distance: 0", "contacts.contact_distance: found '0'"},
        Mistake{"max_contacts: 7", "max_contacts: 0", "contacts.max_contacts: found '0'"},
        Mistake{"resolution: 32", "resolutoin: 32", "contacts.resolutoin: found an unknown key"}));

TEST_F(RobotDescriptionTest, ReadsObstacles) {
  const RobotDescription robot = read(kYaml);
  ASSERT_EQ(robot.obstacles.size(), 2U);
  const ObstacleDescription& floor = robot.obstacles[0];
  EXPECT_EQ(floor.name, "floor");
  EXPECT_FALSE(floor.tracked);
  ASSERT_EQ(floor.geometries.size(), 1U);
  EXPECT_EQ(floor.geometries[0].kind, ObstacleGeometry::Kind::kPlane);
  EXPECT_LT((floor.geometries[0].origin.linear() * Vec3::UnitZ() + Vec3::UnitZ()).norm(), 1e-12);
  EXPECT_EQ(floor.geometries[0].origin.translation(), Vec3(0, 0, 0.3));
  const ObstacleDescription& post = robot.obstacles[1];
  EXPECT_TRUE(post.tracked);
  EXPECT_EQ(post.geometries[0].kind, ObstacleGeometry::Kind::kCylinder);
  EXPECT_LT((post.pose.translation() - Vec3(0.3, 0, 1)).norm(), 1e-12) << "in the frame of the hanging robot";
}

TEST_F(RobotDescriptionTest, TakesFromItsBaseWhatItLeavesOut) {
  folder.write("base.yaml", kYaml);
  const RobotDescription base = readRobotDescription(folder.path() + "/base.yaml");
  const RobotDescription robot = read("name: other\nbase: base.yaml\nobstacles: []\ncontrol: {newton_steps: 7}\n");
  EXPECT_EQ(robot.name, "other");
  EXPECT_EQ(robot.file, folder.path() + "/arm.yaml");
  EXPECT_EQ(robot.frame, base.frame);
  EXPECT_EQ(robot.mesh_file, base.mesh_file);
  EXPECT_EQ(robot.gravity, base.gravity);
  EXPECT_EQ(robot.cables.size(), base.cables.size());
  EXPECT_EQ(robot.contacts.max_contacts, base.contacts.max_contacts);
  EXPECT_TRUE(robot.obstacles.empty());
  EXPECT_EQ(robot.control.newton_steps, 7);
  EXPECT_EQ(robot.control.max_node_step, ControlDescription().max_node_step) << "a key is taken as a whole";
}

TEST_F(RobotDescriptionTest, ReadsHowContactsAreFound) {
  const ContactDescription contacts = read(kYaml).contacts;
  EXPECT_EQ(contacts.method, DetectionMethod::kVolume);
  EXPECT_EQ(contacts.alarm_distance, 0.004);
  EXPECT_EQ(contacts.contact_distance, 0.002);
  EXPECT_TRUE(contacts.self);
  EXPECT_EQ(contacts.max_contacts, 7);
  EXPECT_EQ(contacts.resolution, 32);
}

constexpr const char* kRegions = R"(self: [[tip, palm], [tip, tip]], regions: [
  {name: tip, boxes: [{min: [0, 0, 1], max: [1, 1, 2]}]}, {name: palm, spheres: [{centre: [1, 2, 3], radius: 4}]}])";

TEST_F(RobotDescriptionTest, ReadsWhichRegionsTouch) {
  const ContactDescription contacts = readWith("self: true", kRegions).contacts;
  EXPECT_TRUE(contacts.self);
  ASSERT_EQ(contacts.regions.size(), 2U);
  EXPECT_EQ(contacts.regions[0].name, "tip");
  EXPECT_TRUE(contacts.regions[0].contains(Vec3(1, 0, 2)));
  EXPECT_FALSE(contacts.regions[0].contains(Vec3(1, 0, 2.1)));
  EXPECT_TRUE(contacts.regions[1].contains(Vec3(1, 2, 7)));
  EXPECT_FALSE(contacts.regions[1].contains(Vec3(1, 2.1, 7)));
  EXPECT_EQ(contacts.self_pairs, (std::vector<std::array<int, 2>>{{{0, 1}}, {{0, 0}}}));
  EXPECT_TRUE(read(kYaml).contacts.self_pairs.empty()) << "true: everything with everything";
  EXPECT_FALSE(readWith("self: true", "self: []").contacts.self);
}

struct RegionMistake {
  std::string from, to, complaint;
};

class RegionMistakes : public RobotDescriptionTest, public testing::WithParamInterface<RegionMistake> {};

TEST_P(RegionMistakes, AreNamed) {
  const std::string regions = replaced(kRegions, GetParam().from, GetParam().to);
  const std::string words = complaintOf([&] { readWith("self: true", regions); });
  EXPECT_NE(words.find("arm.yaml: contacts." + GetParam().complaint), std::string::npos) << words;
}

INSTANTIATE_TEST_SUITE_P(
    Regions, RegionMistakes,
    testing::Values(
        RegionMistake{"[tip, palm]", "[tip, plam]", "self: found [[tip, plam], [tip, tip]], expected true, false, or"},
        RegionMistake{"[tip, palm]", "[tip]", "self: found [[tip], [tip, tip]], expected true, false, or"},
        RegionMistake{"[tip, palm]", "tip", "self: found [tip, [tip, tip]], expected a list of lists of texts"},
        RegionMistake{"[[tip, palm], [tip, tip]]", "maybe", "self: found 'maybe', expected true or false"},
        RegionMistake{"name: palm", "name: tip", "regions[1].name: found 'tip', expected a name used once"},
        RegionMistake{"boxes: [{min: [0, 0, 1], max: [1, 1, 2]}]", "boxes: []", "regions[0].boxes: found []"},
        RegionMistake{"max: [1, 1, 2]", "max: [1, -1, 2]", "regions[0].boxes[0].max: found [1, -1, 2]"},
        RegionMistake{"radius: 4", "radius: 0", "regions[1].spheres[0].radius: found '0'"},
        RegionMistake{"spheres:", "balls:", "regions[1]."}));

INSTANTIATE_TEST_SUITE_P(
    Misspelt, RobotMistake,
    testing::Values(Mistake{"damping: {", "dampin: {", "dampin: found an unknown key"},
                    Mistake{"scale:", "scal:", "mesh.scal: found an unknown key"},
                    Mistake{"frame: world", "fram: world", "gravity.fram: found an unknown key"},
                    Mistake{"region: 4", "regoin: 4", "materials[0].regoin: found an unknown key"},
                    Mistake{"mass: 2,", "mas: 2,", "damping.mas: found an unknown key"},
                    Mistake{"nodes: [7, 8]", "node: [7, 8]", "fixed.node: found an unknown key"},
                    Mistake{"min: [-1, -2, -3],", "min: [-1, -2, -3], mid: 0,", "fixed.boxes[0].mid: found an unknown"},
                    Mistake{"radius: 0.5", "radius: 0.5, r: 1", "fixed.spheres[0].r: found an unknown key"},
                    Mistake{"weight: 2.5", "weigth: 2.5", "effectors[0].weigth: found an unknown key"},
                    Mistake{"displacement:", "displacment:", "cables[0].displacment: found an unknown key"},
                    Mistake{"max: 20", "maxi: 20", "cables[0].tension.maxi: found an unknown key"},
                    Mistake{"smoothing:", "smooth:", "control.smooth: found an unknown key"}));

TEST_F(RobotDescriptionTest, NamesAFrameThatTheUrdfDoesNotHave) {
  const std::string complaint = complaintOf([&] { readWith("frame: arm_frame", "frame: elsewhere"); });
  EXPECT_EQ(complaint,
            folder.path() + "/arm.urdf: link: found 'elsewhere', expected one of its links: arm_frame post world");
  EXPECT_NE(complaintOf([&] { readWith("frame: world", "frame: earth"); }).find("found 'earth'"), std::string::npos);
}

TEST_F(RobotDescriptionTest, NamesAFileThatIsNotThere) {
  EXPECT_EQ(complaintOf([&] { readRobotDescription(folder.path() + "/none.yaml"); }),
            folder.path() + "/none.yaml: found no readable file, expected a YAML file");
  const std::string complaint = complaintOf([&] { readWith("urdf: arm.urdf", "urdf: none.urdf"); });
  EXPECT_EQ(complaint, folder.path() + "/none.urdf: found no readable URDF, expected a URDF file");
}

}  // namespace
}  // namespace sinew
