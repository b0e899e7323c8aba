#include "qpcc_oracle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "check_line.h"
#include "qpcc_enumeration.h"
#include "sinew/solver/complementarity_tableau.h"
#include "sinew/solver/piece_qp.h"

namespace sinew {
namespace {

constexpr int kMaxFullContacts = 7;  // up to which the full formulation is enumerated too
constexpr double kOptimal = 1e-6;    // relative, of objectives
constexpr double kNear = 1e-3;       // the same, of pieces that may be the best one
constexpr double kInfinity = std::numeric_limits<double>::infinity();

double calcPercent(int part, int whole) {
  return 100.0 * part / std::max(1, whole);
}

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

}  // namespace

void QpccTally::comparePieces(const QpccProblem& problem, const std::vector<char>& answer, std::mt19937& random) {
  FullQpcc full(problem);
  ReducedQpcc reduced(problem);
  for (int k = 0; k < 3; ++k) {
    std::vector<char> active = k == 0 ? answer : activeSetOf(static_cast<unsigned>(random()), problem.size.contacts);
    active.resize(static_cast<std::size_t>(problem.size.contacts));
    reduced.dropMerged(active);
    const double in_full = full.solvePiece(active);
    const double in_reduced = reduced.solvePiece(active);
    if (in_full == kInfinity && in_reduced == kInfinity) continue;
    ++pieces_;
    if (in_full == kInfinity || in_reduced == kInfinity)
      ++pieces_disagreeing_;
    else
      piece_difference_ = std::max(piece_difference_, std::abs(calcExcess(in_reduced, in_full, problem)));
  }
}

void QpccTally::compareEnumerations(const QpccProblem& problem, double reduced, double full) {
  if (std::isfinite(full) && std::isfinite(reduced))
    full_difference_ = std::max(full_difference_, std::abs(calcExcess(reduced, full, problem)));
  else
    enumerations_disagreeing_ += std::isfinite(full) != std::isfinite(reduced);
}

void QpccTally::checkSolved(const QpccProblem& problem, const QpccSolution& solution, double optimum) {
  ++solved_;
  const double excess = calcExcess(solution.objective, optimum, problem);
  const bool found = excess <= kOptimal;
  found_ += found;
  proved_ += solution.proved_global;
  wrong_proofs_ += solution.proved_global && !found;
  excess_ = std::max(excess_, -excess);
  const double alone = solution.decomposition_objective;
  worse_than_decomposition_ += calcExcess(solution.objective, alone, problem) > kOptimal;
  trapped_ += calcExcess(alone, optimum, problem) > 0.01;

  const QpccResiduals residuals =
      calcResiduals(problem, solution.x.head(problem.size.unknowns), solution.z.head(problem.size.contacts));
  gap_ = std::max(gap_, residuals.gap);
  force_ = std::max(force_, residuals.force);
  complementarity_ = std::max(complementarity_, residuals.complementarity);
  limits_ = std::max(limits_, residuals.limits);
  energy_ = std::max(energy_, std::abs(calcExcess(residuals.objective, solution.objective, problem)));
}

void QpccTally::checkViolated(const QpccProblem& problem, const QpccSolution& solution) {
  (solution.status == QpccStatus::kGivenWay ? given_way_ : infeasible_)++;
  wrong_proofs_ += solution.proved_global;
  if (problem.size.contacts > kMaxFullContacts) return;
  const double least = FullQpcc(problem).enumerateSoftViolation();
  if (least == kInfinity || solution.status == QpccStatus::kInfeasible) {
    wrong_status_ += (least == kInfinity) != (solution.status == QpccStatus::kInfeasible);
    return;
  }
  const VecX range = problem.soft_upper - problem.soft_lower;
  const double violation = solution.soft_violation.head(range.size()).cwiseQuotient(range).maxCoeff();
  ++violations_checked_;
  least_violation_ += std::abs(violation - least) <= 1e-6 * std::max(1.0, least);
}

void QpccTally::add(const QpccProblem& problem, const QpccSolution& solution, std::mt19937& random) {
  ++problems_;
  comparePieces(problem, solution.active, random);
  FullQpcc full(problem);
  const double optimum = ReducedQpcc(problem).enumerate(full);
  if (problem.size.contacts <= kMaxFullContacts) compareEnumerations(problem, optimum, full.enumerate());
  if ((solution.status == QpccStatus::kSolved) != std::isfinite(optimum)) {
    ++wrong_status_;
  } else if (solution.status == QpccStatus::kSolved) {
    checkSolved(problem, solution, optimum);
  } else {
    checkViolated(problem, solution);
  }
}

double QpccTally::calcTrapped() const {
  return calcPercent(trapped_, solved_);
}

void QpccTally::check(const std::string& prefix) const {
  const auto figure = [&](const char* name, double value, const char* op, double bound, const char* unit) {
    checkFigure(prefix + name, value, op, bound, unit);
  };
  figure("reduced_minus_full_piece", piece_difference_, "<=", 1e-6, "1");
  figure("reduced_minus_full_optimum", full_difference_, "<=", 1e-6, "1");
  figure("optima_disagreeing", enumerations_disagreeing_, "<=", 0, "1");
  figure("pieces_disagreeing", calcPercent(pieces_disagreeing_, pieces_), "<=", 0.1, "%");
  figure("found", calcPercent(found_, solved_), ">=", 99.9, "%");
  figure("proved", calcPercent(proved_, solved_), ">=", 90, "%");
  figure("wrong_proofs", wrong_proofs_, "<=", 0, "1");
  figure("below_optimum", excess_, "<=", 1e-6, "1");
  figure("worse_than_decomposition", worse_than_decomposition_, "<=", 0, "1");
  figure("wrong_status", wrong_status_, "<=", 0, "1");
  if (violations_checked_ > 0) {
    figure("least_violation", calcPercent(least_violation_, violations_checked_), ">=", 99, "%");
  }
  figure("gap", gap_, "<=", 1e-9, "m");
  figure("force", force_, "<=", 1e-9, "1");
  figure("complementarity", complementarity_, "<=", 1e-12, "1");
  figure("limits", limits_, "<=", 1e-8, "1");
  figure("objective", energy_, "<=", 1e-9, "1");
}

}  // namespace sinew
