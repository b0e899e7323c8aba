// The tables of the simulate command, in and out, on a small bar with two cables.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <memory>
#include <sstream>
#include <string>

#include "mesh/bar_mesh.h"
#include "simulate_actuation.h"
#include "simulate_targets.h"
#include "sinew/common/config_error.h"

namespace sinew {
namespace {

CableDescription makeCable(const std::string& name, double y) {
  CableDescription cable;
  cable.name = name;
  cable.pull_point = Vec3(-0.01, y, 0.01);
  for (double x : {0.01, 0.04, 0.08}) cable.via_points.emplace_back(x, y, 0.01);
  cable.displacement = {-0.03, 0.03, 0.2};
  cable.tension.min = 0;
  return cable;
}

EffectorDescription makeEffector(const std::string& name, double x, std::array<bool, 3> axes) {
  EffectorDescription effector;
  effector.name = name;
  effector.point = Vec3(x, 0.01, 0.01);
  effector.axes = axes;
  return effector;
}

/// A soft bar along x, 80 mm long, held at x = 0, a cable on either side.
std::shared_ptr<const RobotModel> makeBar() {
  RobotDescription bar;
  bar.name = "bar";
  bar.file = "bar.yaml";
  bar.gravity = Vec3(0, 0, -9.81);
  MaterialDescription rubber;
  rubber.young_modulus = 1e5;
  rubber.poisson_ratio = 0.3;
  rubber.density = 1000;
  bar.materials = {rubber};
  bar.fixed.boxes = {{Vec3(-1, -1, -1), Vec3(1e-6, 1, 1)}};
  bar.cables = {makeCable("left", 0.019), makeCable("right", 0.001)};
  bar.effectors = {makeEffector("tip", 0.08, {{false, true, false}}),
                   makeEffector("middle", 0.04, {{true, true, true}})};
  return std::make_shared<const RobotModel>(bar, makeBarMesh(Vec3(0.08, 0.02, 0.02), 8, 2, 2));
}

CsvTable readText(const std::string& text) {
  return CsvTable::fromText(text, "table.csv");
}

/// Runs `simulate(writer)` and reads back what it wrote.
template <typename Simulate>
CsvTable record(const RobotModel& robot, Simulate&& simulate) {
  const std::string path = testing::TempDir() + "simulate_test_run.csv";
  RunWriter writer(path, robot);
  simulate(writer);
  writer.close();
  CsvTable table = CsvTable::fromFile(path);
  std::remove(path.c_str());
  return table;
}

CsvTable settle(std::shared_ptr<const RobotModel> robot, const CsvTable& actuation) {
  return record(*robot, [&](RunWriter& writer) {
    EXPECT_EQ(settleActuation(robot, readActuationSignal(actuation, *robot), ObstacleSignal(*robot), writer).not_ok, 0);
  });
}

double last(const CsvTable& table, const std::string& column) {
  return table.numbers(column)[table.rows() - 1];
}

template <typename Call>
std::string complaintOf(Call&& call) {
  try {
    call();
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

TEST(Simulate, WritesTheColumnsOfARun) {
  std::string names;
  for (const std::string& column : makeRunColumns(*makeBar())) names += column + " ";
  EXPECT_EQ(names,
            "t target_tip_x target_tip_y target_tip_z effector_tip_x effector_tip_y effector_tip_z "
            "target_middle_x target_middle_y target_middle_z effector_middle_x effector_middle_y effector_middle_z "
            "displacement_left effort_left displacement_right effort_right status residual contacts ");
}

TEST(Simulate, BringsEveryRowOfAnActuationToEquilibrium) {
  const CsvTable run = settle(makeBar(), readText("t,displacement_left\n0,0\n5,0.004\n7,0\n"));
  ASSERT_EQ(run.rows(), 3);
  EXPECT_EQ(run.numbers("t"), Vec3(0, 5, 7));
  EXPECT_NEAR(run.numbers("displacement_left")[1], 0.004, 1e-10);
  EXPECT_GT(run.numbers("effort_left")[1], 0.01);
  const VecX tip = run.numbers("effector_tip_y");
  EXPECT_GT(tip[1], tip[0] + 0.001);  // towards the cable that pulls
  EXPECT_NEAR(tip[2], tip[0], 1e-8);
  EXPECT_LT(run.numbers("residual").maxCoeff(), 1e-8);
}

TEST(Simulate, TakesEffortsAsGiven) {
  const CsvTable run = settle(makeBar(), readText("t,displacement_left,effort_right\n0,-0.01,0\n1,-0.01,0.05\n"));
  EXPECT_EQ(last(run, "effort_right"), 0.05);
  EXPECT_EQ(last(run, "effort_left"), 0);
  const VecX pulled = run.numbers("displacement_right"), tip = run.numbers("effector_tip_y");
  EXPECT_GT(pulled[1], pulled[0] + 1e-4);
  EXPECT_LT(tip[1], tip[0] - 1e-4);
}

TEST(Simulate, StepsThroughAnActuationToTheSameEquilibrium) {
  const auto robot = makeBar();
  const CsvTable actuation = readText("t,displacement_left\n0,0\n0.2,0.004\n1,0.004\n");
  const CsvTable stepped = record(*robot, [&](RunWriter& writer) {
    stepActuation(robot, readActuationSignal(actuation, *robot), ObstacleSignal(*robot), 50, writer);
  });
  ASSERT_EQ(stepped.rows(), 51);
  EXPECT_NEAR(stepped.numbers("t")[1], 0.02, 1e-12);
  EXPECT_NEAR(stepped.numbers("displacement_left")[5], 0.002, 1e-4);  // half way at 0.1 s
  EXPECT_NEAR(last(stepped, "effector_tip_y"), last(settle(robot, actuation), "effector_tip_y"), 1e-7);
}

TEST(Simulate, ReachesWhatAForwardRunReached) {
  const auto robot = makeBar();
  const CsvTable forward =
      settle(robot, readText("t,displacement_left,displacement_right\n0,0,-0.01\n1,0.005,-0.01\n"));
  std::ostringstream text;
  text.precision(17);
  text << "t,target_tip_y\n0," << 0.01 << "\n1," << last(forward, "effector_tip_y") << "\n2,"
       << last(forward, "effector_tip_y") << "\n";
  const CsvTable inverse = record(*robot, [&](RunWriter& writer) {
    const RunSummary summary =
        simulateTargets(robot, readTargetSignal(readText(text.str()), *robot), ObstacleSignal(*robot), 100, writer);
    EXPECT_EQ(summary.rows, 201);
    EXPECT_EQ(summary.not_ok, 0);
    EXPECT_LT(summary.mean_error, 1e-4);
  });
  EXPECT_NEAR(last(inverse, "effector_tip_y"), last(forward, "effector_tip_y"), 1e-8);
  EXPECT_NEAR(last(inverse, "displacement_left"), 0.005, 5e-5);
}

TEST(Simulate, ReadsARunAsAnActuation) {
  const auto robot = makeBar();
  const CsvTable first = settle(robot, readText("t,displacement_left\n0,0.001\n1,0.003\n"));
  const CsvTable second = settle(robot, first);
  EXPECT_NEAR(last(second, "effector_tip_y"), last(first, "effector_tip_y"), 1e-8);
}

TEST(Simulate, RecordsTheContactProblems) {
  RobotDescription description = makeBar()->description();
  ObstacleDescription floor;
  floor.name = "floor";
  floor.geometries.emplace_back();
  floor.geometries[0].kind = ObstacleGeometry::Kind::kPlane;
  floor.pose = Pose(Eigen::Translation3d(0, 0, -0.004));
  description.obstacles = {floor};
  const auto robot = std::make_shared<const RobotModel>(description, makeBarMesh(Vec3(0.08, 0.02, 0.02), 8, 2, 2));
  const std::string path = testing::TempDir() + "simulate_test_contacts.txt";
  ContactRecorder recorder(path, *robot);
  const CsvTable targets = readText("t,target_tip_y\n0,0.01\n0.1,0.012\n");
  record(*robot, [&](RunWriter& writer) {
    simulateTargets(robot, readTargetSignal(targets, *robot), ObstacleSignal(*robot), 100, writer, &recorder);
  });
  recorder.close();
  EXPECT_EQ(recorder.records(), 11);
  std::ifstream file(path);
  int records = 0, ends = 0, visits = 0;
  for (std::string line; std::getline(file, line);) {
    records += line.rfind("record ", 0) == 0 && line.find(" left right") != std::string::npos;
    visits += line.rfind("visit ", 0) == 0;
    ends += line == "done";
  }
  EXPECT_EQ(records, 11);
  EXPECT_EQ(ends, 11);
  EXPECT_GE(visits, 11);
  std::remove(path.c_str());
  EXPECT_NE(complaintOf([&] { ContactRecorder("no/such/folder/c.txt", *robot); }).find("no/such"), std::string::npos);
}

TEST(Simulate, InterpolatesTargetsAndLeavesOtherEffectorsFree) {
  const auto robot = makeBar();
  const TargetSignal targets = readTargetSignal(readText("t,target_tip_y\n1,0.010\n3,0.012\n"), *robot);
  EXPECT_EQ(targets.targeted, (std::vector<bool>{true, false}));
  VecX value;
  targets.positions.calcValue(2, value);
  EXPECT_NEAR(value[1], 0.011, 1e-12);
  EXPECT_EQ(value[0], 0.08);  // not controlled: the point at rest
}

TEST(Simulate, NamesWhatIsWrongInATable) {
  const auto robot = makeBar();
  const auto targets = [&](const std::string& text) {
    return complaintOf([&] { readTargetSignal(readText(text), *robot); });
  };
  const auto actuation = [&](const std::string& text) {
    return complaintOf([&] { readActuationSignal(readText(text), *robot); });
  };
  EXPECT_EQ(targets("t,target_tip_y\n0,0\n"), "");
  EXPECT_NE(targets("t,target_top_y\n0,0\n").find("column target_top_y"), std::string::npos);
  EXPECT_NE(targets("t,target_middle_y\n0,0\n").find("no column target_middle_x"), std::string::npos);
  EXPECT_NE(targets("t\n0\n").find("no column target_NAME_x"), std::string::npos);
  EXPECT_NE(targets("target_tip_y\n0\n").find("no column t"), std::string::npos);
  EXPECT_NE(targets("t,target_tip_y\n0,nan\n").find("table.csv:2: target_tip_y: found nan"), std::string::npos);
  EXPECT_NE(targets("t,target_tip_y\n0,0\n0,0\n").find("table.csv:3: t"), std::string::npos);
  EXPECT_NE(actuation("t,displacement_top\n0,0\n").find("column displacement_top"), std::string::npos);
  EXPECT_NE(actuation("t\n0\n").find("no column displacement_NAME"), std::string::npos);
}

TEST(Simulate, WritesNumbersThatReadBackTheSame) {
  const auto robot = makeBar();
  RunRow row;
  row.time = 0.1;
  row.targets = VecX::Constant(6, 1.0 / 3);
  row.effectors = VecX::LinSpaced(6, -1e-300, 1e300);
  row.displacement = Eigen::Vector2d(std::nextafter(1.0, 2.0), -0.0);
  row.effort = Eigen::Vector2d(1e-17, 2.5);
  row.status = "ok";
  const CsvTable table = record(*robot, [&](RunWriter& writer) { writer.write(row); });
  EXPECT_EQ(table.numbers("t")[0], row.time);
  EXPECT_EQ(table.numbers("target_tip_x")[0], 1.0 / 3);
  EXPECT_EQ(table.numbers("effector_middle_z")[0], 1e300);
  EXPECT_EQ(table.numbers("displacement_left")[0], row.displacement[0]);
  EXPECT_EQ(table.numbers("effort_left")[0], 1e-17);
}

TEST(Simulate, CountsBothEndsOfAnInterval) {
  EXPECT_EQ(countCycles(0, 0, 100), 1);
  EXPECT_EQ(countCycles(0, 1, 100), 101);
  EXPECT_EQ(countCycles(0.1, 0.3, 10), 3);
  EXPECT_EQ(countCycles(0, 0.099, 10), 1);
}

TEST(Simulate, RefusesAFileThatCannotBeWritten) {
  EXPECT_NE(complaintOf([] { RunWriter("no/such/folder/run.csv", *makeBar()); }).find("no/such/folder/run.csv"),
            std::string::npos);
}

}  // namespace
}  // namespace sinew
