// How often the global optimum of a QPCC is found within a time budget, on one core.
// usage: qpcc_benchmark ROOT [SCENE ...]; ROOT, which all benchmarks are given, does not matter. Scenes are qpcc,
// qpcc_tracking and qpcc_reduced. found_percent: objective within 1e-6 of the best that a search of 200 ms knows;
// alone_percent: the same for the decomposition without a search, in tracking from its own last answer. ratio: time of
// a piece in the full formulation over that in the reduced one, set-up included, both through DenseQp.

#include <sched.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "sinew/solver/complementarity_tableau.h"
#include "sinew/solver/contact_lcp.h"
#include "sinew/solver/dense_qp.h"
#include "sinew/solver/qpcc_solver.h"
#include "solver/qpcc_enumeration.h"
#include "solver/random_qpcc.h"

namespace sinew {
namespace {

using Clock = std::chrono::steady_clock;

constexpr double kReferenceBudget = 0.2;  // s
constexpr double kTurn = 6.283185307179586;

void pinToOneCore() {
  cpu_set_t cores;
  CPU_ZERO(&cores);
  CPU_SET(sched_getcpu(), &cores);
  sched_setaffinity(0, sizeof cores, &cores);
}

double secondsSince(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

QpccBudget makeBudget(double seconds) {
  QpccBudget budget;
  budget.max_pieces = budget.max_nodes = 1 << 30;
  budget.deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
  return budget;
}

QpccBudget makeNoSearch() {
  QpccBudget budget;
  budget.restarts = budget.max_nodes = 0;
  return budget;
}

/// Relative to the objective, or to a thousandth of that at rest where it is smaller; infinite if not solved.
double calcExcess(const QpccSolution& solution, double reference, const QpccProblem& problem) {
  if (solution.status != QpccStatus::kSolved) return std::numeric_limits<double>::infinity();
  if (solution.objective == reference) return 0;
  return (solution.objective - reference) / (std::abs(reference) + 1e-3 * 0.5 * problem.e.squaredNorm());
}

class Tally {
 public:
  void add(const QpccProblem& problem, const QpccSolution& solution, const QpccSolution& alone, double reference,
           double seconds) {
    found_ += calcExcess(solution, reference, problem) <= 1e-6;
    alone_ += calcExcess(alone, reference, problem) <= 1e-6;
    proved_ += solution.proved_global;
    seconds_.push_back(seconds);
  }

  void print(int unknowns, int contacts, const std::string& kind, double budget) {
    std::sort(seconds_.begin(), seconds_.end());
    std::printf(
        "scene=qpcc na=%d nc=%d kind=%s budget_ms=%.2f found_percent=%.2f proved_percent=%.2f median_us=%.1f "
        "p99_us=%.1f alone_percent=%.2f problems=%zu\n",
        unknowns, contacts, kind.c_str(), 1e3 * budget, percent(found_), percent(proved_), 1e6 * calcQuantile(0.5),
        1e6 * calcQuantile(0.99), percent(alone_), seconds_.size());
    std::fflush(stdout);
  }

 private:
  double percent(int part) const { return 100.0 * part / static_cast<double>(seconds_.size()); }
  double calcQuantile(double share) const {
    return seconds_[static_cast<std::size_t>(share * static_cast<double>(seconds_.size() - 1))];
  }

  int found_ = 0, alone_ = 0, proved_ = 0;
  std::vector<double> seconds_;
};

/// The best objective that two solutions and a long search from the better of them know.
double findReference(const QpccProblem& problem, const QpccSolution& solution, QpccSolver& solver,
                     QpccSolution& scratch) {
  QpccGuess guess(problem.size);
  guess.valid = solution.status == QpccStatus::kSolved;
  guess.x = solution.x;
  guess.active = solution.active;
  solver.solve(problem, guess, makeBudget(kReferenceBudget), scratch);
  const bool searched = scratch.status == QpccStatus::kSolved;
  if (!guess.valid) return searched ? scratch.objective : std::numeric_limits<double>::infinity();
  return searched ? std::min(scratch.objective, solution.objective) : solution.objective;
}

void timeSearch(QpccKind kind, int unknowns, int contacts, double budget, int problems) {
  const QpccSizes size{unknowns, unknowns, 3, contacts};
  std::mt19937 random(static_cast<unsigned>(100 * contacts + unknowns));
  QpccSolver solver(size), reference_solver(size);
  QpccSolution solution(size), alone(size), scratch(size);
  const QpccGuess none(size);
  Tally tally;
  for (int k = 0; k < problems; ++k) {
    const QpccProblem problem = makeQpcc(kind, unknowns, contacts, random);
    const Clock::time_point begin = Clock::now();
    solver.solve(problem, none, makeBudget(budget), solution);
    const double seconds = secondsSince(begin);
    reference_solver.solve(problem, none, makeNoSearch(), alone);
    const double reference = findReference(problem, solution, reference_solver, scratch);
    if (std::isfinite(reference)) tally.add(problem, solution, alone, reference, seconds);
  }
  tally.print(unknowns, contacts, nameOf(kind), budget);
}

/// The target goes round in front of bars that tilt on obstacles; each cycle starts from the last answer.
void timeTracking(int unknowns, int contacts, double budget, int scenes, int cycles) {
  const QpccSizes size{unknowns, unknowns, 3, contacts};
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(0, 1);
  QpccSolver solver(size), alone_solver(size), reference_solver(size);
  QpccSolution solution(size), alone(size), scratch(size);
  Tally tally;
  for (int k = 0; k < scenes; ++k) {
    QpccProblem problem = makeQpcc(QpccKind::kLever, unknowns, contacts, random);
    const double radius = 0.01 + 0.03 * uniform(random);
    const double phase = kTurn * uniform(random);
    QpccGuess guess(size), alone_guess(size);
    for (int cycle = 0; cycle < cycles; ++cycle) {
      const double angle = phase + kTurn * cycle / cycles;
      problem.e = Vec3(-radius * std::cos(angle), -radius * std::sin(2 * angle), 0);
      const Clock::time_point begin = Clock::now();
      solver.solve(problem, guess, makeBudget(budget), solution);
      const double seconds = secondsSince(begin);
      alone_solver.solve(problem, alone_guess, makeNoSearch(), alone);
      const double reference = findReference(problem, solution, reference_solver, scratch);
      tally.add(problem, solution, alone, reference, seconds);
      for (const auto& [next, last] : {std::make_pair(&guess, &solution), std::make_pair(&alone_guess, &alone)}) {
        next->valid = last->status == QpccStatus::kSolved;
        next->x = last->x;
        next->active = last->active;
      }
    }
  }
  tally.print(unknowns, contacts, "tracking", budget);
}

/// The piece QP in n_a unknowns, formed from a tableau.
class ReducedPiece {
 public:
  explicit ReducedPiece(const QpccProblem& problem)
      : scaled_(problem.size),
        tableau_(problem.size),
        qp_(problem.size.unknowns, problem.size.contacts + problem.size.rows),
        solution_(qp_.variables, qp_.rows),
        solver_(qp_.variables, qp_.rows) {
    scaled_.update(problem);
    tableau_.reset(scaled_);
  }

  ComplementarityTableau& tableau() { return tableau_; }
  const ScaledQpcc& scaled() const { return scaled_; }

  bool solve(const std::vector<char>& active) {
    tableau_.moveTo(active);
    const int n = scaled_.size.unknowns;
    const int m = scaled_.limitedRows();
    const auto map = tableau_.map();
    const auto E = map.bottomRows(scaled_.size.effectors);
    qp_.resize(n, m);
    qp_.G = scaled_.Q;
    qp_.G.noalias() += E.leftCols(n).transpose() * E.leftCols(n);
    qp_.g = scaled_.q + E.leftCols(n).transpose() * E.col(n);
    qp_.C.topRows(m) = map.topLeftCorner(m, n);
    qp_.row_lower.head(m) = scaled_.row_lower.head(m) - map.col(n).head(m);
    qp_.row_upper.head(m) = scaled_.row_upper.head(m) - map.col(n).head(m);
    qp_.lower = scaled_.x_lower.cwiseMax(scaled_.soft_lower);
    qp_.upper = scaled_.x_upper.cwiseMin(scaled_.soft_upper);
    solver_.forget();
    return solver_.solve(qp_, solution_) == QpStatus::kSolved;
  }

 private:
  ScaledQpcc scaled_;
  ComplementarityTableau tableau_;
  QpProblem qp_;
  QpSolution solution_;
  DenseQp solver_;
};

/// Pieces of random actuations of random problems, each by both formulations.
void timeFormulations(int unknowns, int contacts, int problems) {
  constexpr int kPieces = 20;
  constexpr int kPasses = 5;
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(0, 1);
  double full_seconds = 0;
  double reduced_seconds = 0;
  for (int k = 0; k < problems; ++k) {
    const QpccProblem problem = makeQpcc(QpccKind::kRandom, unknowns, contacts, random);
    ReducedPiece reduced(problem);
    FullQpcc full(problem);
    const ScaledQpcc& scaled = reduced.scaled();
    if (scaled.size.contacts < contacts) continue;
    std::vector<std::vector<char>> pieces;
    ComplementarityTableau& tableau = reduced.tableau();
    for (int piece = 0; piece < kPieces; ++piece) {
      VecX x = scaled.soft_lower;
      for (int j = 0; j < unknowns; ++j) x(j) += uniform(random) * (scaled.soft_upper(j) - scaled.soft_lower(j));
      if (solveContactLcp(x, tableau)) pieces.push_back(tableau.active());
    }
    // The best of some passes through the pieces, each in the same order.
    std::vector<double> full_best(pieces.size(), 1), reduced_best(pieces.size(), 1);
    for (int pass = 0; pass < kPasses; ++pass) {
      tableau.reset(scaled);
      for (std::size_t i = 0; i < pieces.size(); ++i) {
        const Clock::time_point begin = Clock::now();
        const bool full_solved = std::isfinite(full.solvePiece(pieces[i]));
        const Clock::time_point middle = Clock::now();
        const bool reduced_solved = reduced.solve(pieces[i]);
        const Clock::time_point end = Clock::now();
        const bool solved = full_solved && reduced_solved;
        const std::chrono::duration<double> in_full = middle - begin;
        const std::chrono::duration<double> in_reduced = end - middle;
        full_best[i] = solved ? std::min(full_best[i], in_full.count()) : 0;
        reduced_best[i] = solved ? std::min(reduced_best[i], in_reduced.count()) : 0;
      }
    }
    full_seconds = std::accumulate(full_best.begin(), full_best.end(), full_seconds);
    reduced_seconds = std::accumulate(reduced_best.begin(), reduced_best.end(), reduced_seconds);
  }
  std::printf("scene=qpcc_reduced na=%d nc=%d ratio=%.2f\n", unknowns, contacts, full_seconds / reduced_seconds);
  std::fflush(stdout);
}

void runSearch() {
  timeSearch(QpccKind::kRandom, 3, 10, 2e-4, 500);
  timeSearch(QpccKind::kBar, 3, 10, 2e-4, 500);
  timeSearch(QpccKind::kLever, 3, 10, 2e-4, 500);
  timeSearch(QpccKind::kBar, 4, 20, 2e-4, 500);
  timeSearch(QpccKind::kBar, 8, 40, 1e-3, 300);
  timeSearch(QpccKind::kBar, 8, 76, 1e-3, 300);
}

void runTracking() {
  timeTracking(8, 40, 1e-3, 20, 50);
}

void runReduced() {
  timeFormulations(3, 3, 100);
  timeFormulations(3, 10, 50);
  timeFormulations(3, 50, 10);
}

int runAll(const std::vector<std::string>& names) {
  struct Scene {
    std::string name;
    void (*run)();
  };
  const std::vector<Scene> scenes = {{"qpcc", runSearch}, {"qpcc_tracking", runTracking}, {"qpcc_reduced", runReduced}};
  for (const std::string& name : names) {
    if (std::any_of(scenes.begin(), scenes.end(), [&](const Scene& scene) { return scene.name == name; })) continue;
    std::fprintf(stderr, "no scene %s; there are: qpcc qpcc_tracking qpcc_reduced\n", name.c_str());
    return 2;
  }
  for (const Scene& scene : scenes)
    if (names.empty() || std::find(names.begin(), names.end(), scene.name) != names.end()) scene.run();
  return 0;
}

}  // namespace
}  // namespace sinew

int main(int argc, char** argv) {
  sinew::pinToOneCore();
  return sinew::runAll(std::vector<std::string>(argv + std::min(argc, 2), argv + argc));
}
