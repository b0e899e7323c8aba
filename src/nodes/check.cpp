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

#include "check_advice.h"
#include "check_timing.h"
#include "real_time.h"
#include "sinew/constraint/cable.h"
#include "sinew/constraint/point_effector.h"
#include "sinew/fem/fem_model.h"
#include "sinew/mesh/quality.h"
#include "sinew/robot/robot_description.h"

namespace sinew {
namespace {

constexpr int kWrongInput = 1;
constexpr int kWrongUsage = 2;
constexpr int kTooSlow = 3;

constexpr char kUsage[] =
    R"(usage: check ROBOT.yaml [--cycles N] [--rate HZ]

Reads a robot's description and prints what the controller makes of it: mesh and its quality, warnings, degrees of
freedom, mass, cables, carrier, effectors, obstacles, and the time that a control cycle takes on this machine, stage by
stage, with the obstacles where they are: the rate that it will reach, and what would make it faster.
Exit code 0 when the robot can be controlled, 1 when not, 2 for a wrong command line, 3 when --rate is not reached.
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

void printObstacles(const RobotModel& robot) {
  for (const Obstacle& obstacle : robot.obstacles()) {
    std::printf("obstacle   %s: %zu part%s, %s\n", obstacle.name.c_str(), obstacle.parts.size(),
                obstacle.parts.size() == 1 ? "" : "s", obstacle.tracked ? "tracked" : "fixed");
  }
}

void printDurations(const char* name, const DurationSample& durations) {
  std::printf("           %-33s %7.3f  %7.3f\n", name, 1e3 * durations.calcQuantile(0.5),
              1e3 * durations.calcQuantile(0.99));
}

void printTiming(const RobotModel& robot, const CycleTiming& timing) {
  std::printf("cycle      %zu cycles of a small motion, ms  median     99 %%\n", timing.cycle.size());
  for (int stage = 0; stage < CycleTiming::kStageCount; ++stage) {
    printDurations(CycleTiming::nameOf(stage), timing.stages[static_cast<std::size_t>(stage)]);
  }
  printDurations("whole cycle", timing.cycle);
  printDurations("whole cycle, linearisation shared", timing.sharedCycle);
  if (robot.maxContacts() > 0) std::printf("contacts   %d at once in this motion\n", timing.contacts);
  std::printf("rate       up to %.0f Hz, with a quarter of each period to spare\n", timing.predictRate());
  std::printf("           up to %.0f Hz in overload, where cycles share linearisations\n", timing.predictSharedRate());
  for (const std::string& words : advise(robot.description(), timing)) std::printf("faster     %s\n", words.c_str());
}

bool reaches(double rate, const CycleTiming& timing) {
  if (rate <= timing.predictRate()) return true;
  std::printf(
      "problem    %.4g Hz are asked for, this machine reaches %.0f Hz: 99 %% of the cycles take up to %.3f ms,\n"
      "           and %.3f ms would leave a quarter of each period to spare\n",
      rate, timing.predictRate(), 1e3 * timing.cycle.calcQuantile(0.99), 1e3 * CycleTiming::calcLongest(rate));
  if (rate <= timing.predictSharedRate()) {
    std::printf("           commands will go out at that rate, but degraded: cycles will share linearisations\n");
  }
  return false;
}

void printWarnings(const RobotModel& robot) {
  for (const std::string& warning : robot.warnings()) std::printf("warning    %s\n", warning.c_str());
  if (robot.warnings().empty()) std::printf("warnings   none\n");
}

/// Exit code. `rate` in Hz, 0 for any.
int check(const std::string& file, int cycles, double rate) {
  const auto robot = std::make_shared<const RobotModel>(readRobotDescription(file));
  std::printf("robot      %s\n", robot->description().name.c_str());
  printMesh(*robot);
  printBody(*robot);
  printCables(*robot);
  printCarrier(robot->description().carrier);
  printEffectors(*robot);
  printObstacles(*robot);
  printWarnings(*robot);
  const std::string not_allowed = requestRealTime(kCyclePriority);  // as the controller's node does
  if (!not_allowed.empty()) std::printf("timing     not in real time: %s\n", not_allowed.c_str());
  const CycleTiming timing = timeCycles(robot, cycles);
  printTiming(*robot, timing);
  if (!timing.rests) {
    std::printf("problem    no equilibrium with slack cables: too soft for its weight, or an obstacle in its way\n");
  }
  if (timing.held > 0) std::printf("problem    %d of %d cycles were not solved\n", timing.held, 2 * cycles);
  if (!timing.rests || timing.held > 0) return kWrongInput;
  return reaches(rate, timing) ? 0 : kTooSlow;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  namespace options = boost::program_options;
  std::string file;
  int cycles = 200;
  double rate = 0;
  options::options_description named("options"), all;
  named.add_options()("help", "this text");
  named.add_options()("cycles", options::value(&cycles)->value_name("N")->default_value(cycles), "cycles to time")(
      "rate", options::value(&rate)->value_name("HZ"), "of the controller; exit code 3 when it is not reached");
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
    if (values.count("rate") > 0 && !(rate > 0 && std::isfinite(rate))) throw options::error("--rate must be above 0");
    return sinew::check(file, cycles, rate);
  } catch (const options::error& error) {
    std::cerr << "check: " << error.what() << "; see check --help\n";
    return sinew::kWrongUsage;
  } catch (const std::exception& error) {
    std::cerr << "check: " << error.what() << "\n";
    return sinew::kWrongInput;
  }
}
