#include "sinew/inverse/robot_model.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>

#include "common/complaint.h"
#include "inverse/bar_robot.h"
#include "sinew/constraint/cable.h"
#include "sinew/constraint/point_effector.h"

namespace sinew {
namespace {

TEST(RobotModel, ShippedRobotsLoadWithoutWarnings) {
  int robots = 0;
  for (const auto& folder : std::filesystem::directory_iterator(SINEW_SOURCE_DIR "/config")) {
    const std::filesystem::path file = folder.path() / (folder.path().filename().string() + ".yaml");
    if (!std::filesystem::exists(file)) continue;
    const RobotModel robot(readRobotDescription(file.string()));
    for (const std::string& warning : robot.warnings()) ADD_FAILURE() << warning;
    EXPECT_GT(robot.actuatorCount(), 0);
    EXPECT_GT(robot.effectorCount(), 0);
    ++robots;
  }
  EXPECT_GE(robots, 2);
}

TEST(RobotModel, IsMadeOfWhatIsDescribed) {
  const auto robot = makeBarRobot();
  EXPECT_TRUE(robot->warnings().empty());
  EXPECT_EQ(robot->actuatorCount(), 4);
  EXPECT_EQ(robot->effectorCount(), 1);
  EXPECT_EQ(robot->findActuator("cable_3"), 2);
  EXPECT_EQ(robot->findActuator("tip"), -1);
  EXPECT_EQ(robot->findEffector("tip"), 0);
  EXPECT_EQ(robot->findEffector("cable_3"), -1);
  EXPECT_EQ(robot->fem().freeCount(), 8 * 9);
  EXPECT_EQ(robot->surface().triangles.size(), 2U * (2 * 8 * 2 + 2 * 8 * 2 + 2 * 2 * 2));
  EXPECT_NEAR(robot->cables()[0].restLength(), 0.095, 1e-15);
  EXPECT_LT((robot->effectors()[0].calcPosition(robot->fem().rest()) - Vec3(0.1, 0.01, 0.01)).norm(), 1e-15);
}

TEST(RobotModel, FixesWhatIsInAnyShapeOrList) {
  RobotDescription description = makeBarDescription();
  description.fixed.spheres.push_back({Vec3(0.1, 0, 0), 0.0101});  // the corner and its neighbours along the edges
  description.fixed.nodes = {4};
  const auto robot = makeBarRobot(description);
  for (int node = 0; node < robot->fem().nodeCount(); ++node) {
    const Vec3& x = robot->mesh().nodes[node];
    const bool fixed = x.x() <= 0 || (x - Vec3(0.1, 0, 0)).norm() < 0.0101 || node == 4;
    EXPECT_EQ(robot->fem().freeIndex(node) < 0, fixed) << node;
  }
}

TEST(RobotModel, TotalMassIsSpreadOverItsRegions) {
  RobotDescription description = makeBarDescription();
  const double mass = makeBarRobot(description)->fem().mass().sum();
  description.materials[0].density = 0;
  description.materials[0].total_mass = 1000 * 0.1 * 0.02 * 0.02;
  EXPECT_NEAR(makeBarRobot(description)->fem().mass().sum(), mass, 1e-12);
}

TEST(RobotModel, RegionsTakeTheirOwnMaterialOrTheOneForAllOthers) {
  TetMesh mesh = makeBarRobotMesh();
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) mesh.region[t] = t % 2 == 0 ? 5 : static_cast<int>(t % 3);
  RobotDescription description = makeBarDescription();
  MaterialDescription stiff = description.materials[0];
  stiff.region = 5;
  stiff.young_modulus = 1e7;
  description.materials.push_back(stiff);
  const RobotModel robot(description, mesh);
  for (std::size_t t = 0; t < mesh.tets.size(); ++t) {
    const double expected = calcLame(t % 2 == 0 ? 1e7 : 2e5, 0.3).mu;
    EXPECT_EQ(robot.fem().elements()[t].lame.mu, expected);
  }
}

struct Mistake {
  const char* name;
  std::function<void(RobotDescription&)> make;
  const char* complaint;
};

class RobotModelMistake : public testing::TestWithParam<Mistake> {};

TEST_P(RobotModelMistake, IsNamedInFull) {
  RobotDescription description = makeBarDescription();
  GetParam().make(description);
  const std::string complaint = complaintOf([&] { makeBarRobot(description); });
  EXPECT_EQ(complaint.find(GetParam().complaint), 0U) << complaint;
}

INSTANTIATE_TEST_SUITE_P(
    Unheld, RobotModelMistake,
    testing::Values(Mistake{"Nowhere", [](RobotDescription& robot) { robot.fixed = {}; },
                            "bar.yaml: fixed: found 0 fixed nodes, expected three fixed nodes or more"},
                    Mistake{"AtTwoNodes",
                            [](RobotDescription& robot) {
                              robot.fixed = {};
                              robot.fixed.nodes = {0, 9};
                            },
                            "bar.yaml: fixed: found 2 fixed nodes, expected"},
                    Mistake{"AlongALine",
                            [](RobotDescription& robot) {
                              robot.fixed = {};
                              robot.fixed.nodes = {0, 9, 18};
                            },
                            "bar.yaml: fixed: found 3 fixed nodes on one line, expected"},
                    Mistake{"AtANodeThatIsNot",
                            [](RobotDescription& robot) {
                              robot.fixed.nodes = {3, 81};
                            },
                            "bar.yaml: fixed.nodes: found 81, expected a node index below 81"}),
    [](const auto& mistake) { return std::string(mistake.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Misplaced, RobotModelMistake,
    testing::Values(Mistake{"ViaPoint", [](RobotDescription& robot) { robot.cables[1].via_points[2].z() = -0.05; },
                            "bar.yaml: cables[1].via_points[2]: found [0.095, 0.018, -0.05], 50 mm outside the mesh"},
                    Mistake{"Effector", [](RobotDescription& robot) { robot.effectors[0].point = Vec3(100, 10, 10); },
                            "bar.yaml: effectors[0].point: found [100, 10, 10], "},
                    Mistake{"CableInFixedNodes",
                            [](RobotDescription& robot) {
                              robot.fixed.boxes[0].max.x() = 0.026;
                              robot.cables[3].via_points = {Vec3(0.005, 0.01, 0.01), Vec3(0.02, 0.01, 0.01)};
                              robot.cables[3].displacement.max = 0.001;
                            },
                            "bar.yaml: cables[3].via_points: found only fixed nodes around it"},
                    Mistake{"EffectorOnTheClamp", [](RobotDescription& robot) { robot.effectors[0].point.x() = 0; },
                            "bar.yaml: effectors[0].point: found only fixed nodes around it"},
                    Mistake{"EffectorInFixedNodes",
                            [](RobotDescription& robot) {
                              robot.fixed.boxes[0].max.x() = 0.026;
                              robot.effectors[0].point.x() = 0.02;
                            },
                            "bar.yaml: effectors[0].point: found only fixed nodes around it"},
                    Mistake{"CablePulledInWhole",
                            [](RobotDescription& robot) { robot.cables[2].displacement.max = 0.096; },
                            "bar.yaml: cables[2].displacement.max: found 0.096 m, expected less than the cable's rest "
                            "length, 0.095 m"}),
    [](const auto& mistake) { return std::string(mistake.param.name); });

INSTANTIATE_TEST_SUITE_P(
    Materials, RobotModelMistake,
    testing::Values(Mistake{"None", [](RobotDescription& robot) { robot.materials[0].region = 3; },
                            "bar.yaml: materials: found no material for region 0 of the mesh"},
                    Mistake{"OfAnUnknownRegion",
                            [](RobotDescription& robot) {
                              robot.materials.push_back(robot.materials[0]);
                              robot.materials[1].region = 7;
                            },
                            "bar.yaml: materials.region: found 7, expected one of the mesh's regions: 0"}),
    [](const auto& mistake) { return std::string(mistake.param.name); });

TEST(RobotModel, RefusesAMeshThatCannotBeSimulated) {
  TetMesh mesh = makeBarRobotMesh();
  std::swap(mesh.tets[7][0], mesh.tets[7][1]);
  const std::string complaint = complaintOf([&] { RobotModel(makeBarDescription(), mesh); });
  EXPECT_EQ(complaint.find("bar.msh: found "), 0U) << complaint;
}

class RobotModelWarning : public testing::TestWithParam<Mistake> {};

TEST_P(RobotModelWarning, DoesNotStopTheRobot) {
  RobotDescription description = makeBarDescription();
  GetParam().make(description);
  const auto robot = makeBarRobot(description);
  ASSERT_EQ(robot->warnings().size(), 1U);
  EXPECT_NE(robot->warnings()[0].find(GetParam().complaint), std::string::npos) << robot->warnings()[0];
}

INSTANTIATE_TEST_SUITE_P(
    Suspicions, RobotModelWarning,
    testing::Values(
        Mistake{"PointJustOutside", [](RobotDescription& robot) { robot.effectors[0].point.x() = 0.1015; },
                "effectors[0].point: [0.1015, 0.01, 0.01] lies 1.5 mm outside the mesh"},
        Mistake{"ViaPointJustOutside", [](RobotDescription& robot) { robot.cables[0].via_points[1].y() = -0.002; },
                "cables[0].via_points[1]: [0.06, -0.002, 0.002] lies 2 mm outside the mesh"},
        Mistake{"Locking", [](RobotDescription& robot) { robot.materials[0].poisson_ratio = 0.48; }, "lock"},
        Mistake{"KiloPascal", [](RobotDescription& robot) { robot.materials[0].young_modulus = 250; }, "kPa?"},
        Mistake{"Steel", [](RobotDescription& robot) { robot.materials[0].young_modulus = 1e12; }, "steel"},
        Mistake{"GramPerCubicCentimetre", [](RobotDescription& robot) { robot.materials[0].density = 1.08; },
                "g/cm3?"}),
    [](const auto& mistake) { return std::string(mistake.param.name); });

TEST(RobotModel, CarriesAPointOutsideByTheNearestTetrahedron) {
  RobotDescription description = makeBarDescription();
  description.effectors[0].point.x() = 0.1015;
  const auto robot = makeBarRobot(description);
  EXPECT_LT((robot->effectors()[0].calcPosition(robot->fem().rest()) - Vec3(0.1015, 0.01, 0.01)).norm(), 1e-15);
}

}  // namespace
}  // namespace sinew
