#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "check_line.h"
#include "qpcc_enumeration.h"
#include "random_qpcc.h"
#include "sinew/solver/complementarity_tableau.h"
#include "sinew/solver/piece_qp.h"
#include "sinew/solver/qpcc_solver.h"

namespace sinew {
namespace {

constexpr int kProblems = 5000;
constexpr int kMaxFullContacts = 7;  // up to which the full formulation is enumerated too
constexpr double kOptimal = 1e-6;    // relative, of objectives
constexpr double kNear = 1e-3;       // the same, of pieces that may be the best one
constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The complementarity choices of a QPCC in n_a unknowns, on the tableau.
class ReducedQpcc {
 public:
  explicit ReducedQpcc(const QpccProblem& problem)
      : scaled_(problem.size), tableau_(problem.size), piece_(problem.size), answer_(problem.size) {
    scaled_.update(problem);
    tableau_.reset(scaled_);
    piece_.attach(scaled_);
  }

  /// Takes contacts out of `active` that duplicate others.
  void dropMerged(std::vector<char>& active) const {
    std::vector<char> kept(active.size(), 0);
    for (int k = 0; k < scaled_.size.contacts; ++k) {
      const auto i = static_cast<std::size_t>(scaled_.contact[static_cast<std::size_t>(k)]);
      kept[i] = active[i];
    }
    active = kept;
  }

  /// `active` in the contacts of the problem, none of them merged.
  double solvePiece(const std::vector<char>& active) {
    std::vector<char> own(active.size(), 0);
    for (int k = 0; k < scaled_.size.contacts; ++k)
      own[static_cast<std::size_t>(k)] = active[static_cast<std::size_t>(scaled_.contact[static_cast<std::size_t>(k)])];
    tableau_.moveTo(own);
    MatX map = tableau_.map();
    if (!tableau_.refine(map)) map = tableau_.map();
    return solve(map);
  }

  /// Over all pieces, in the order of a Gray code; the pieces near the best one by the full formulation.
  double enumerate(FullQpcc& full) {
    struct Piece {
      double objective;
      std::vector<char> active;
    };
    std::vector<Piece> pieces;
    const int count = 1 << scaled_.size.contacts;
    tableau_.reset(scaled_);
    for (int k = 0; k < count; ++k) {
      int moved = 0;
      while (k > 0 && !((k >> moved) & 1)) ++moved;
      if (k > 0) tableau_.pivot(moved);
      const double objective = solve(tableau_.map());
      if (std::isfinite(objective)) pieces.push_back({objective, tableau_.active()});
    }
    double best = kInfinity;
    for (const Piece& piece : pieces) best = std::min(best, piece.objective);
    double exact = kInfinity;
    for (const Piece& piece : pieces) {
      if (piece.objective > best + kNear * std::abs(best)) continue;
      std::vector<char> active(piece.active.size(), 0);
      for (int k = 0; k < scaled_.size.contacts; ++k)
        active[static_cast<std::size_t>(scaled_.contact[static_cast<std::size_t>(k)])] =
            piece.active[static_cast<std::size_t>(k)];
      exact = std::min(exact, full.solvePiece(active));
    }
    return exact;
  }

 private:
  double solve(const Eigen::Ref<const MatX>& map) {
    return piece_.solve(map, answer_) ? answer_.merit.objective * scaled_.objectiveUnit() : kInfinity;
  }

  ScaledQpcc scaled_;
  ComplementarityTableau tableau_;
  PieceQp piece_;
  PieceAnswer answer_;
};

/// Relative to the objective, or to a thousandth of that at rest where it is smaller.
double calcExcess(double value, double reference, const QpccProblem& problem) {
  if (value == reference) return 0;
  return (value - reference) / (std::abs(reference) + 1e-3 * 0.5 * problem.e.squaredNorm());
}

/// Every kind and size, with dependent and duplicate contacts, rates, rows held, and limits that exclude each other.
QpccProblem drawProblem(int number, std::mt19937& random) {
  const int na = 1 + static_cast<int>(random() % 6);
  const int nc = static_cast<int>(number % 2 == 0 ? random() % 11 : 6 + random() % 5);
  constexpr QpccKind kKinds[] = {QpccKind::kRandom, QpccKind::kLever, QpccKind::kBar, QpccKind::kLever};
  const QpccKind kind = kKinds[number % 4];
  QpccProblem problem = makeQpcc(kind, na, nc, random);
  const auto share = [&random] { return std::uniform_real_distribution<double>(0, 1)(random); };
  const int variant = number / 4 % 8;
  if (nc >= 2 && variant == 1) duplicateContact(0, 1, random() % 2 == 0 ? 0 : 1e-4, problem);
  if (nc >= 3 && variant == 2) averageContacts(0, 1, 2, problem);
  if (variant == 3) limitRates(problem.soft_upper * share(), 0.2, problem);
  if (variant == 4) holdRow(0, 0.8 * share(), problem);
  if (variant == 5) holdRow(0, 1.2 + share(), problem);
  if (variant == 6 && random() % 4 == 0) {
    limitRates(VecX::Zero(na), 1, problem);
    problem.row_lower(0) = problem.row_upper(0) = 100 * problem.row_upper(0);
  }
  return problem;
}

struct Tally {
  int solved = 0, found = 0, proved = 0, wrong_proofs = 0, worse_than_decomposition = 0, decomposition_trapped = 0;
  int given_way = 0, infeasible = 0, wrong_status = 0, least_violation = 0, violations_checked = 0;
  int pieces = 0, pieces_disagreeing = 0, enumerations = 0, enumerations_disagreeing = 0;
  double piece_difference = 0, full_difference = 0, excess = 0, energy = 0;
  double gap = 0, force = 0, complementarity = 0, limits = 0;
};

void comparePieces(const QpccProblem& problem, const std::vector<char>& answer, std::mt19937& random, Tally& tally) {
  FullQpcc full(problem);
  ReducedQpcc reduced(problem);
  for (int k = 0; k < 3; ++k) {
    std::vector<char> active = k == 0 ? answer : activeSetOf(static_cast<unsigned>(random()), problem.size.contacts);
    active.resize(static_cast<std::size_t>(problem.size.contacts));
    reduced.dropMerged(active);
    const double in_full = full.solvePiece(active);
    const double in_reduced = reduced.solvePiece(active);
    if (in_full == kInfinity && in_reduced == kInfinity) continue;
    ++tally.pieces;
    if (in_full == kInfinity || in_reduced == kInfinity)
      ++tally.pieces_disagreeing;
    else
      tally.piece_difference = std::max(tally.piece_difference, std::abs(calcExcess(in_reduced, in_full, problem)));
  }
}

void compareEnumerations(const QpccProblem& problem, double reduced, double full, Tally& tally) {
  ++tally.enumerations;
  if (std::isfinite(full) && std::isfinite(reduced))
    tally.full_difference = std::max(tally.full_difference, std::abs(calcExcess(reduced, full, problem)));
  else
    tally.enumerations_disagreeing += std::isfinite(full) != std::isfinite(reduced);
}

void checkSolved(const QpccProblem& problem, const QpccSolution& solution, double optimum, Tally& tally) {
  ++tally.solved;
  const double excess = calcExcess(solution.objective, optimum, problem);
  const bool found = excess <= kOptimal;
  tally.found += found;
  tally.proved += solution.proved_global;
  tally.wrong_proofs += solution.proved_global && !found;
  tally.excess = std::max(tally.excess, -excess);
  const double alone = solution.decomposition_objective;
  tally.worse_than_decomposition += calcExcess(solution.objective, alone, problem) > kOptimal;
  tally.decomposition_trapped += calcExcess(alone, optimum, problem) > 0.01;

  const QpccResiduals residuals =
      calcResiduals(problem, solution.x.head(problem.size.unknowns), solution.z.head(problem.size.contacts));
  tally.gap = std::max(tally.gap, residuals.gap);
  tally.force = std::max(tally.force, residuals.force);
  tally.complementarity = std::max(tally.complementarity, residuals.complementarity);
  tally.limits = std::max(tally.limits, residuals.limits);
  tally.energy = std::max(tally.energy, std::abs(calcExcess(residuals.objective, solution.objective, problem)));
}

void checkViolated(const QpccProblem& problem, const QpccSolution& solution, Tally& tally) {
  (solution.status == QpccStatus::kGivenWay ? tally.given_way : tally.infeasible)++;
  tally.wrong_proofs += solution.proved_global;
  if (problem.size.contacts > kMaxFullContacts) return;
  const double least = FullQpcc(problem).enumerateSoftViolation();
  if (least == kInfinity || solution.status == QpccStatus::kInfeasible) {
    tally.wrong_status += (least == kInfinity) != (solution.status == QpccStatus::kInfeasible);
    return;
  }
  const VecX range = problem.soft_upper - problem.soft_lower;
  const double violation = solution.soft_violation.head(range.size()).cwiseQuotient(range).maxCoeff();
  ++tally.violations_checked;
  tally.least_violation += std::abs(violation - least) <= 1e-6 * std::max(1.0, least);
}

TEST(QpccOracle, agreesWithEnumeration) {
  std::mt19937 random(20);
  const QpccSizes capacity{6, 6, 3, 10};
  QpccSolver solver(capacity);
  QpccSolution solution(capacity);
  const QpccGuess none(capacity);
  QpccBudget budget;
  budget.max_pieces = 400;
  budget.max_nodes = 400;
  Tally tally;
  for (int number = 0; number < kProblems; ++number) {
    const QpccProblem problem = drawProblem(number, random);
    solver.solve(problem, none, budget, solution);
    comparePieces(problem, solution.active, random, tally);
    FullQpcc full(problem);
    const double optimum = ReducedQpcc(problem).enumerate(full);
    if (problem.size.contacts <= kMaxFullContacts) compareEnumerations(problem, optimum, full.enumerate(), tally);
    if ((solution.status == QpccStatus::kSolved) != std::isfinite(optimum)) {
      ++tally.wrong_status;
    } else if (solution.status == QpccStatus::kSolved) {
      checkSolved(problem, solution, optimum, tally);
    } else {
      checkViolated(problem, solution, tally);
    }
  }
  const auto percent = [](int part, int whole) { return 100.0 * part / std::max(1, whole); };
  checkFigure("qpcc_oracle.problems", kProblems, ">=", 5000, "1");
  checkFigure("qpcc_oracle.solved", tally.solved, ">=", 0.7 * kProblems, "1");
  checkFigure("qpcc_oracle.reduced_minus_full_piece", tally.piece_difference, "<=", 1e-6, "1");
  checkFigure("qpcc_oracle.reduced_minus_full_optimum", tally.full_difference, "<=", 1e-6, "1");
  checkFigure("qpcc_oracle.optima_disagreeing", tally.enumerations_disagreeing, "<=", 0, "1");
  checkFigure("qpcc_oracle.pieces_disagreeing", percent(tally.pieces_disagreeing, tally.pieces), "<=", 0.1, "%");
  checkFigure("qpcc_oracle.found", percent(tally.found, tally.solved), ">=", 99.9, "%");
  checkFigure("qpcc_oracle.proved", percent(tally.proved, tally.solved), ">=", 90, "%");
  checkFigure("qpcc_oracle.wrong_proofs", tally.wrong_proofs, "<=", 0, "1");
  checkFigure("qpcc_oracle.below_optimum", tally.excess, "<=", 1e-6, "1");
  checkFigure("qpcc_oracle.worse_than_decomposition", tally.worse_than_decomposition, "<=", 0, "1");
  checkFigure("qpcc_oracle.decomposition_trapped", percent(tally.decomposition_trapped, tally.solved), ">=", 10, "%");
  checkFigure("qpcc_oracle.wrong_status", percent(tally.wrong_status, kProblems), "<=", 0.1, "%");
  checkFigure("qpcc_oracle.given_way", tally.given_way, ">=", 100, "1");
  checkFigure("qpcc_oracle.infeasible", tally.infeasible, ">=", 20, "1");
  checkFigure("qpcc_oracle.least_violation", percent(tally.least_violation, tally.violations_checked), ">=", 99, "%");
  checkFigure("qpcc_oracle.gap", tally.gap, "<=", 1e-9, "m");
  checkFigure("qpcc_oracle.force", tally.force, "<=", 1e-9, "1");
  checkFigure("qpcc_oracle.complementarity", tally.complementarity, "<=", 1e-12, "1");
  checkFigure("qpcc_oracle.limits", tally.limits, "<=", 1e-8, "1");
  checkFigure("qpcc_oracle.objective", tally.energy, "<=", 1e-9, "1");
}

}  // namespace
}  // namespace sinew
