// Targets and obstacles move, appear and vanish at random for minutes of the robot's time: every cycle has an answer
// within what the devices allow, and says where a limit gave way.

#include <algorithm>
#include <cstdlib>
#include <random>

#include "check_line.h"
#include "inverse/robots.h"

namespace sinew {
namespace {

constexpr double kPeriod = 0.01;         // s
constexpr double kFastest = 0.1;         // m/s, of obstacles and targets
constexpr double kRounding = 1e-9;       // of a limit
constexpr double kVisibleEffort = 1e-6;  // N beyond a limit, from which on it must be reported

double calcSeconds(double seconds) {
  return std::getenv("SINEW_FULL") != nullptr ? 15 * seconds : seconds;
}

/// Walks straight from one random place in a box to the next.
class Wanderer {
 public:
  Wanderer(const Vec3& lower, const Vec3& upper) : lower_(lower), upper_(upper) {}

  const Vec3& step(std::mt19937& random) {
    if ((goal_ - place_).norm() < speed_ * kPeriod || speed_ == 0) {
      goal_ = draw(random);
      speed_ = std::uniform_real_distribution<double>(0.1, 1)(random) * kFastest;
    }
    place_ += speed_ * kPeriod * (goal_ - place_).normalized();
    return place_;
  }
  void jump(std::mt19937& random) { place_ = draw(random), goal_ = draw(random); }

 private:
  Vec3 draw(std::mt19937& random) const {
    Vec3 place;
    for (int k = 0; k < 3; ++k) place[k] = std::uniform_real_distribution<double>(lower_[k], upper_[k])(random);
    return place;
  }

  Vec3 lower_, upper_;
  Vec3 place_ = 0.5 * (lower_ + upper_), goal_ = place_;
  double speed_ = 0;  // m/s
};

/// What went wrong over a run.
struct Faults {
  int held = 0, degraded = 0, not_finite = 0, beyond_range = 0, beyond_rate = 0, unreported = 0, in_contact = 0;

  void add(const RobotModel& robot, const VecX& before, const CycleOutput& output) {
    held += output.status == CycleStatus::kHeld;
    degraded += output.status == CycleStatus::kDegraded;
    in_contact += output.contacts.count > 0 && output.contacts.force.head(output.contacts.count).maxCoeff() > 0;
    not_finite += !(output.displacement.allFinite() && output.effort.allFinite() && output.effectors.allFinite() &&
                    std::isfinite(output.effector_error));
    for (int i = 0; i < robot.actuatorCount(); ++i) {
      const Limits& range = robot.description().cables[i].displacement;
      const double command = output.displacement[i], step = range.rate * kPeriod;
      beyond_range += !(command >= range.min && command <= range.max);
      beyond_rate += !(std::abs(command - before[i]) <= step * (1 + kRounding));
      unreported += givesWayUnreported(robot, output, i);
    }
  }

  static bool givesWayUnreported(const RobotModel& robot, const CycleOutput& output, int actuator) {
    const Limits& tension = robot.description().cables[actuator].tension;
    const double effort = output.effort[actuator];
    const double beyond = std::max(tension.min - effort, effort - tension.max);
    if (beyond <= kVisibleEffort) return false;
    const LimitKind kind = effort < tension.min ? LimitKind::kEffortMin : LimitKind::kEffortMax;
    return std::none_of(output.limits.begin(), output.limits.end(), [&](const ActiveLimitReport& limit) {
      return limit.actuator == actuator && limit.kind == kind && std::abs(limit.violation - beyond) <= 1e-9;
    });
  }

  void check(const std::string& name, int cycles) const {
    checkFigure("contact_soak." + name + "_held_cycles", held, "<=", 0, "1");
    checkFigure("contact_soak." + name + "_not_finite", not_finite, "<=", 0, "1");
    checkFigure("contact_soak." + name + "_beyond_range", beyond_range, "<=", 0, "1");
    checkFigure("contact_soak." + name + "_beyond_rate", beyond_rate, "<=", 0, "1");
    checkFigure("contact_soak." + name + "_unreported_limits", unreported, "<=", 0, "1");
    std::printf("%s: %d cycles, %d in contact, %d with a tension that gave way\n", name.c_str(), cycles, in_contact,
                degraded);
    EXPECT_GT(in_contact, cycles / 10);
  }
};

ObstacleDescription makeTrackedSphere(const std::string& name, double radius) {
  ObstacleDescription sphere;
  sphere.name = name;
  sphere.tracked = true;
  sphere.geometries.resize(1);
  sphere.geometries[0].kind = ObstacleGeometry::Kind::kSphere;
  sphere.geometries[0].radius = radius;
  return sphere;
}

struct Space {
  Vec3 lower, upper;  // m
};

void soak(const std::string& name, const RobotDescription& description, const Space& targets, const Space& obstacles,
          double seconds) {
  const auto robot = makeRobot(description);
  InverseController controller(robot);
  controller.resynchronise(VecX::Zero(robot->actuatorCount()));
  CycleInput input = controller.makeInput();
  CycleOutput output = controller.makeOutput();
  input.targeted[0] = true;
  std::mt19937 random(1);
  Wanderer target(targets.lower, targets.upper);
  std::vector<Wanderer> walks(robot->obstacles().size(), Wanderer(obstacles.lower, obstacles.upper));
  for (const Obstacle& obstacle : robot->obstacles()) input.obstacles.push_back({obstacle.pose, false});
  Faults faults;
  const int cycles = static_cast<int>(std::lround(calcSeconds(seconds) / kPeriod));
  for (int k = 0; k < cycles; ++k) {
    if (random() % 500 == 0) target.jump(random);
    input.targets.head<3>() = target.step(random);
    for (std::size_t i = 0; i < walks.size(); ++i) {
      if (random() % 200 == 0) {
        input.obstacles[i].present = !input.obstacles[i].present;
        walks[i].jump(random);
      }
      input.obstacles[i].pose.translation() = walks[i].step(random);
    }
    const VecX before = output.displacement;
    controller.step(input, output);
    faults.add(*robot, before, output);
  }
  faults.check(name, cycles);
}

TEST(ContactSoak, Trunk) {
  RobotDescription description = readShippedRobot("trunk_cylinder");
  description.obstacles.push_back(makeTrackedSphere("ball", 0.015));
  description.obstacles.push_back(makeTrackedSphere("small_ball", 0.008));
  soak("trunk", description, {Vec3(-0.06, -0.06, 0.14), Vec3(0.06, 0.06, 0.2)},
       {Vec3(-0.06, -0.06, 0.03), Vec3(0.06, 0.06, 0.22)}, 40);
}

TEST(ContactSoak, Finger) {
  RobotDescription description = readShippedRobot("finger");
  description.obstacles[0].tracked = true;
  description.obstacles.push_back(makeTrackedSphere("ball", 0.01));
  description.contacts.self = true;
  description.contacts.alarm_distance = 0.003;
  description.contacts.contact_distance = 0.0005;
  soak("finger", description, {Vec3(-0.01, -0.01, 0.06), Vec3(0.01, 0.06, 0.1)},
       {Vec3(-0.03, -0.03, 0.02), Vec3(0.03, 0.05, 0.12)}, 80);
}

}  // namespace
}  // namespace sinew
