// The contact problems of live robots, their goals and limits drawn anew, against the enumeration of all pieces.

#include "solver/qpcc_oracle.h"

#include <algorithm>
#include <memory>
#include <random>
#include <vector>

#include "check_line.h"
#include "inverse/contact_robot.h"
#include "inverse/robots.h"
#include "sinew/inverse/contact_search.h"
#include "sinew/solver/qpcc_solver.h"

namespace sinew {
namespace {

constexpr int kBars = 84;
constexpr int kMaxContacts = 10;
constexpr int kCycles = 60;
constexpr int kProblemsPerBar = 36;
constexpr int kProblemsOfFinger = 400;

class Draw {
 public:
  explicit Draw(unsigned seed) : random_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Vec3 inBox(double half) { return Vec3(between(-half, half), between(-half, half), between(-half, half)); }
  bool once(int in) { return random_() % static_cast<unsigned>(in) == 0; }
  std::mt19937& engine() { return random_; }

 private:
  std::mt19937 random_;
};

/// One to six cables along the bar, each as long as it happens to be, and an obstacle on two or three of its sides.
RobotDescription drawBar(int cables, Draw& draw) {
  RobotDescription robot = makeContactDescription({});
  const CableDescription shape = robot.cables[0];
  robot.cables.clear();
  for (int k = 0; k < cables; ++k) {
    CableDescription cable = shape;
    cable.name = "cable_" + std::to_string(k);
    const Vec3 edge(0, draw.once(2) ? 0.002 : 0.018, draw.between(0.002, 0.018));
    cable.pull_point = edge;
    const double end = draw.between(0.04, 0.095);
    cable.via_points = {edge + Vec3(0.5 * end, 0, 0), edge + Vec3(end, 0, 0)};
    robot.cables.push_back(cable);
  }
  robot.obstacles = {makeFloor(draw.between(-0.004, -0.001))};
  robot.obstacles.push_back(makeCylinder(0.01, Vec3(draw.between(0.03, 0.1), 0.01, draw.between(0.032, 0.036))));
  if (draw.once(2)) robot.obstacles.push_back(makeSphere(0.012, Vec3(draw.between(0.05, 0.1), 0.034, 0.01)));
  robot.contacts.max_contacts = kMaxContacts;
  robot.control.reach_per_cycle = 0.05;
  return robot;
}

/// The problem of a cycle with another goal and other limits: farther away, to the side, with or without rates.
QpccProblem drawVariant(const QpccProblem& recorded, Draw& draw) {
  QpccProblem p = recorded;
  const double reach = draw.once(2) ? 0.03 : 0.003;
  p.e.head(p.size.effectors) = draw.inBox(reach).head(p.size.effectors);
  for (int j = 0; j < p.size.unknowns; ++j) {
    const double present = -recorded.soft_lower(j);  // N, of a cable that pulls only
    p.soft_upper(j) = draw.between(0.5, 10) - std::min(present, 0.4);
    if (draw.once(3)) p.x_lower(j) = -(p.x_upper(j) = draw.between(0.5, 3));
    const double middle = p.a(j), half = draw.once(2) ? 0.02 : 0.002;
    p.row_lower(j) = middle - draw.between(0, half);
    p.row_upper(j) = middle + draw.between(0, half);
  }
  if (draw.once(8)) p.row_lower(0) = p.row_upper(0) = p.a(0) + draw.between(-0.002, 0.002);
  return p;
}

/// Of the leading entries that count.
QpccProblem trim(const QpccProblem& problem) {
  QpccProblem p(problem.size);
  const int na = p.size.unknowns, nr = p.size.rows, ne = p.size.effectors, nc = p.size.contacts;
  p.E_a = problem.E_a.topLeftCorner(ne, na);
  p.E_c = problem.E_c.topLeftCorner(ne, nc);
  p.e = problem.e.head(ne);
  p.Q = problem.Q.topLeftCorner(na, na);
  p.q = problem.q.head(na);
  p.x_lower = problem.x_lower.head(na);
  p.x_upper = problem.x_upper.head(na);
  p.soft_lower = problem.soft_lower.head(na);
  p.soft_upper = problem.soft_upper.head(na);
  p.A_a = problem.A_a.topLeftCorner(nr, na);
  p.A_c = problem.A_c.topLeftCorner(nr, nc);
  p.a = problem.a.head(nr);
  p.row_lower = problem.row_lower.head(nr);
  p.row_upper = problem.row_upper.head(nr);
  p.C_a = problem.C_a.topLeftCorner(nc, na);
  p.C_c = problem.C_c.topLeftCorner(nc, nc);
  p.c = problem.c.head(nc);
  return p;
}

/// Holds the solver against the oracle on the problems of a robot whose target jumps about.
class Campaign {
 public:
  void run(const std::shared_ptr<const RobotModel>& robot, const Vec3& centre, double reach, int problems, Draw& draw) {
    InverseController controller(robot);
    CycleInput input = controller.makeInput();
    CycleOutput output = controller.makeOutput();
    input.targeted[0] = true;
    for (int cycle = 0; cycle < kCycles && problems > 0; ++cycle) {
      if (cycle % 10 == 0) input.targets.head<3>() = centre + draw.inBox(reach);
      const bool solved = controller.step(input, output) != CycleStatus::kHeld;
      if (!solved || output.contacts.count == 0 || output.contacts.count > kMaxContacts || cycle % 3 != 0) continue;
      const QpccProblem recorded = trim(controller.contactSearch().problem());
      for (int k = 0; k < 2 && problems > 0; ++k, --problems) compare(drawVariant(recorded, draw), draw);
    }
  }

  const QpccTally& tally() const { return tally_; }

 private:
  void compare(const QpccProblem& problem, Draw& draw) {
    QpccSolver solver(problem.size);
    QpccSolution solution(problem.size);
    QpccBudget budget;
    budget.max_pieces = budget.max_nodes = 400;
    solver.solve(problem, QpccGuess(problem.size), budget, solution);
    tally_.add(problem, solution, draw.engine());
  }

  QpccTally tally_;
};

TEST(QpccOracle, agreesOnLiveRobots) {
  Draw draw(4);
  Campaign campaign;
  for (int k = 0; k < kBars; ++k) {
    const RobotDescription description = drawBar(1 + k % 6, draw);
    campaign.run(makeBarRobot(description), description.effectors[0].point, 0.02, kProblemsPerBar, draw);
  }
  campaign.run(makeRobot(readShippedRobot("finger")), Vec3(0, 0.009, 0.087), 0.015, kProblemsOfFinger, draw);
  const QpccTally& tally = campaign.tally();
  tally.check("qpcc_oracle.live_");
  checkFigure("qpcc_oracle.live_problems", tally.problems(), ">=", 2500, "1");
  checkFigure("qpcc_oracle.live_solved", tally.solved(), ">=", 2000, "1");
  std::printf("live: %d given way, %d infeasible; decomposition alone more than 1 %% above the optimum in %.2f %%\n",
              tally.givenWay(), tally.infeasible(), tally.calcTrapped());
}

}  // namespace
}  // namespace sinew
