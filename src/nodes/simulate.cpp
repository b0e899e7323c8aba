// The inverse controller or the forward simulator on a robot's description, from table to table, without a ROS master.

#include <boost/program_options.hpp>
#include <chrono>
#include <cstdio>
#include <exception>
#include <iostream>
#include <memory>
#include <stdexcept>
#include <string>

#include "simulate_actuation.h"
#include "simulate_contacts.h"
#include "simulate_obstacles.h"
#include "simulate_run.h"
#include "simulate_targets.h"
#include "sinew/robot/robot_description.h"

namespace sinew {
namespace {

namespace options = boost::program_options;

constexpr int kWrongInput = 1;
constexpr int kWrongUsage = 2;

constexpr char kUsage[] =
    R"(usage: simulate ROBOT.yaml --targets TARGETS.csv [--obstacles OBSTACLES.csv] [--rate HZ]
                [--record-contacts CONTACTS.txt] --out RUN.csv
       simulate ROBOT.yaml --forward ACTUATION.csv [--obstacles OBSTACLES.csv] [--settle false [--rate HZ]] --out RUN.csv

Runs the inverse controller along targets, or the forward simulator along an actuation. Units are SI.
  TARGETS.csv    columns t, target_NAME_x, target_NAME_y, target_NAME_z of one effector or more. Linear between the
                 rows; one cycle each 1/HZ from the first t to the last.
  ACTUATION.csv  columns t, and displacement_NAME or effort_NAME of one actuator or more; the displacement counts
                 where both are there, and an actuator without any keeps displacement 0.
  OBSTACLES.csv  columns t, and obstacle_NAME_x, _y, _z of one obstacle of the robot or more; also obstacle_NAME_qx,
                 _qy, _qz, _qw if it turns, and obstacle_NAME_present (1 or 0) if it comes and goes. Robot frame. An
                 obstacle without any stays where the robot's description has it.
  RUN.csv        t; target_NAME_x..z and effector_NAME_x..z per effector; displacement_NAME and effort_NAME per
                 actuator; status (ok, degraded, held; forward: ok, not_converged, failed), residual in N, contacts
                 (how many press).
                 A run can be read again as TARGETS.csv or ACTUATION.csv.
  CONTACTS.txt   the contact problem of every cycle that has one, with guess, path and answer of its search;
                 scripts/plot_qpcc draws it.
Exit code 0 when RUN.csv is complete, 1 for an input that is wrong, 2 for a wrong command line.
)";

struct Settings {
  std::string robot, targets, forward, obstacles, out, contacts;
  double rate = 100;  // Hz
  bool settle = true;
};

class UsageError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

options::options_description makeOptions(Settings& settings) {
  options::options_description named("options");
  auto add = named.add_options();
  add("help", "this text");
  add("targets", options::value(&settings.targets)->value_name("CSV"), "targets of the inverse controller");
  add("forward", options::value(&settings.forward)->value_name("CSV"), "actuation of the forward simulator");
  add("obstacles", options::value(&settings.obstacles)->value_name("CSV"), "where the obstacles are");
  add("out", options::value(&settings.out)->value_name("CSV"), "where the run goes");
  add("record-contacts", options::value(&settings.contacts)->value_name("TXT"), "where the contact problems go");
  add("rate", options::value(&settings.rate)->value_name("HZ")->default_value(settings.rate), "cycles a second");
  add("settle", options::value(&settings.settle)->value_name("BOOL")->default_value(settings.settle, "true"),
      "forward: the equilibrium of each row; false: through time at the rate");
  return named;
}

void checkSettings(const Settings& settings) {
  if (settings.robot.empty()) throw UsageError("ROBOT.yaml is missing");
  if (settings.out.empty()) throw UsageError("--out is missing");
  if (settings.targets.empty() == settings.forward.empty()) throw UsageError("give either --targets or --forward");
  if (!settings.contacts.empty() && settings.targets.empty()) throw UsageError("--record-contacts needs --targets");
  if (!(settings.rate >= 0.1 && settings.rate <= 1e5)) throw UsageError("--rate must be from 0.1 to 100000 Hz");
}

/// False when help was asked for and given.
bool readCommandLine(int argc, char** argv, Settings& settings) {
  const options::options_description named = makeOptions(settings);
  options::options_description all;
  all.add(named).add_options()("robot", options::value(&settings.robot));
  options::positional_options_description positional;
  positional.add("robot", 1);
  options::variables_map values;
  options::store(options::command_line_parser(argc, argv).options(all).positional(positional).run(), values);
  if (values.count("help") > 0) {
    std::cout << kUsage << named;
    return false;
  }
  options::notify(values);
  checkSettings(settings);
  return true;
}

void closeRecord(ContactRecorder& recorder, const std::string& path) {
  recorder.close();
  std::fprintf(stderr, "%s: %d cycles with contacts\n", path.c_str(), recorder.records());
}

RunSummary run(const Settings& settings) {
  const auto robot = std::make_shared<const RobotModel>(readRobotDescription(settings.robot));
  for (const std::string& warning : robot->warnings()) std::cerr << "warning: " << warning << "\n";
  const bool inverse = !settings.targets.empty();
  const ObstacleSignal obstacles = settings.obstacles.empty()
                                       ? ObstacleSignal(*robot)
                                       : ObstacleSignal(CsvTable::fromFile(settings.obstacles), *robot);
  const CsvTable table = CsvTable::fromFile(inverse ? settings.targets : settings.forward);
  RunSummary summary;
  if (inverse) {
    const TargetSignal targets = readTargetSignal(table, *robot);
    RunWriter writer(settings.out, *robot);
    std::unique_ptr<ContactRecorder> recorder;
    if (!settings.contacts.empty()) recorder = std::make_unique<ContactRecorder>(settings.contacts, *robot);
    summary = simulateTargets(robot, targets, obstacles, settings.rate, writer, recorder.get());
    writer.close();
    if (recorder) closeRecord(*recorder, settings.contacts);
  } else {
    const ActuationSignal signal = readActuationSignal(table, *robot);
    RunWriter writer(settings.out, *robot);
    summary = settings.settle ? settleActuation(robot, signal, obstacles, writer)
                              : stepActuation(robot, signal, obstacles, settings.rate, writer);
    writer.close();
  }
  return summary;
}

void report(const Settings& settings, const RunSummary& summary, double seconds) {
  std::fprintf(stderr, "%s: %d rows in %.1f s, %d not ok", settings.out.c_str(), summary.rows, seconds, summary.not_ok);
  if (!settings.targets.empty()) std::fprintf(stderr, ", mean error %.4f mm", 1e3 * summary.mean_error);
  std::fputs("\n", stderr);
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  using Clock = std::chrono::steady_clock;
  try {
    sinew::Settings settings;
    if (!sinew::readCommandLine(argc, argv, settings)) return 0;
    const Clock::time_point begin = Clock::now();
    const sinew::RunSummary summary = sinew::run(settings);
    sinew::report(settings, summary, std::chrono::duration<double>(Clock::now() - begin).count());
    return 0;
  } catch (const boost::program_options::error& error) {
    std::cerr << "simulate: " << error.what() << "; see simulate --help\n";
    return sinew::kWrongUsage;
  } catch (const sinew::UsageError& error) {
    std::cerr << "simulate: " << error.what() << "; see simulate --help\n";
    return sinew::kWrongUsage;
  } catch (const std::exception& error) {
    std::cerr << "simulate: " << error.what() << "\n";
    return sinew::kWrongInput;
  }
}
