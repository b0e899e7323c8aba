// Looks at a robot before it moves: mesh, warnings, sizes, cables, and how fast this machine can control it.

#include <algorithm>
#include <boost/program_options.hpp>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

#include "check_timing.h"
#include "sinew/constraint/cable.h"
#include "sinew/constraint/point_effector.h"
#include "sinew/fem/fem_model.h"
#include "sinew/mesh/quality.h"
#include "sinew/robot/robot_description.h"

namespace sinew {
namespace {

constexpr int kWrongInput = 1;
constexpr int kWrongUsage = 2;

constexpr char kUsage[] =
    R"(usage: check ROBOT.yaml [--cycles N]

Reads a robot's description and prints what the controller makes of it: mesh and its quality, warnings, degrees of
freedom, mass, cables, carrier, effectors, and the time that a control cycle takes on this machine, stage by stage.
Exit code 0 when the robot can be controlled, 1 when not, 2 for a wrong command line.
)";

void printMesh(const RobotModel& robot) {
  const MeshReport mesh = checkMesh(robot.mesh());
  const Vec3 size = mesh.upper - mesh.lower;
  std::printf("mesh       %s\n", robot.description().mesh_file.c_str());
  std::printf("           %d tetrahedra, %d nodes, %d piece%s, worst quality %.2f (1 is regular, below 0.2 a sliver)\n",
              mesh.tets, mesh.nodes, mesh.pieces, mesh.pieces == 1 ? "" : "s", mesh.worst_quality);
  std::printf("           %.4g x %.4g x %.4g m, %.4g m3\n", size.x(), size.y(), size.z(), mesh.volume);
}

void printBody(const RobotModel& robot) {
  const FemModel& fem = robot.fem();
  std::printf("body       %d degrees of freedom, %d fixed nodes, %.4g kg moving\n", fem.size(),
              fem.nodeCount() - fem.freeCount(), fem.mass().sum());
  for (const MaterialDescription& material : robot.description().materials) {
    std::printf("material   %.4g Pa, Poisson's ratio %.3g\n", material.young_modulus, material.poisson_ratio);
  }
}

void printCables(const RobotModel& robot) {
  for (const Cable& cable : robot.cables()) {
    const Limits& range = cable.description().displacement;
    std::printf("cable      %s: %.4g m long, %d points, pulled in %.4g to %.4g m, %.4g m/s, tension to %.4g N\n",
                cable.description().name.c_str(), cable.restLength(), cable.points(), range.min, range.max, range.rate,
                cable.description().tension.max);
  }
}

void printCarrier(const CarrierDescription& carrier) {
  if (carrier.name.empty()) return;
  const Vec3 axis = carrier.axis.normalized();
  std::printf("carrier    %s: along %.3g, %.3g, %.3g, travels %.4g to %.4g m, %.4g m/s\n", carrier.name.c_str(),
              axis.x(), axis.y(), axis.z(), carrier.displacement.min, carrier.displacement.max,
              carrier.displacement.rate);
}

void printEffectors(const RobotModel& robot) {
  for (const PointEffector& effector : robot.effectors()) {
    const Vec3& point = effector.description().point;
    std::printf("effector   %s: at %.4g, %.4g, %.4g m, %d rows, weight %.3g\n", effector.description().name.c_str(),
                point.x(), point.y(), point.z(), effector.rowCount(), effector.description().weight);
  }
}

void printTiming(const CycleTiming& timing) {
  std::printf("cycle      %zu cycles of a small motion, ms  median     99 %%\n", timing.cycle.size());
  for (const CycleTiming::Stage& stage : timing.stages) {
    std::printf("           %-33s %7.3f  %7.3f\n", stage.name.c_str(), 1e3 * stage.durations.calcQuantile(0.5),
                1e3 * stage.durations.calcQuantile(0.99));
  }
  std::printf("           %-33s %7.3f  %7.3f\n", "whole cycle", 1e3 * timing.cycle.calcQuantile(0.5),
              1e3 * timing.cycle.calcQuantile(0.99));
  std::printf("rate       up to %.0f Hz, with a quarter of each period to spare\n", timing.predictRate());
}

void printWarnings(const RobotModel& robot) {
  for (const std::string& warning : robot.warnings()) std::printf("warning    %s\n", warning.c_str());
  if (robot.warnings().empty()) std::printf("warnings   none\n");
}

/// False when the cycles did not all solve.
bool check(const std::string& file, int cycles) {
  const auto robot = std::make_shared<const RobotModel>(readRobotDescription(file));
  std::printf("robot      %s\n", robot->description().name.c_str());
  printMesh(*robot);
  printBody(*robot);
  printCables(*robot);
  printCarrier(robot->description().carrier);
  printEffectors(*robot);
  printWarnings(*robot);
  const CycleTiming timing = timeCycles(robot, cycles);
  printTiming(timing);
  if (!timing.rests) {
    std::printf("problem    no equilibrium with slack cables: too soft for its weight, or an obstacle in its way\n");
  }
  if (timing.held > 0) std::printf("problem    %d of %d cycles were not solved\n", timing.held, cycles);
  return timing.rests && timing.held == 0;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  namespace options = boost::program_options;
  std::string file;
  int cycles = 200;
  options::options_description named("options"), all;
  named.add_options()("help", "this text");
  named.add_options()("cycles", options::value(&cycles)->value_name("N")->default_value(cycles), "cycles to time");
  all.add(named).add_options()("robot", options::value(&file)->required());
  options::positional_options_description positional;
  positional.add("robot", 1);
  try {
    options::variables_map values;
    options::store(options::command_line_parser(argc, argv).options(all).positional(positional).run(), values);
    if (values.count("help") > 0) {
      std::cout << sinew::kUsage << named;
      return 0;
    }
    options::notify(values);
    if (cycles < 1) throw options::error("--cycles must be 1 or more");
    return sinew::check(file, cycles) ? 0 : sinew::kWrongInput;
  } catch (const options::error& error) {
    std::cerr << "check: " << error.what() << "; see check --help\n";
    return sinew::kWrongUsage;
  } catch (const std::exception& error) {
    std::cerr << "check: " << error.what() << "\n";
    return sinew::kWrongInput;
  }
}
