#include "sinew/solver/piece_qp.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kRidge = 1e-10;            // curvature given to flat directions, against the largest
constexpr double kElasticCurvature = 1e-6;  // of x while violations are minimised
constexpr double kViolated = 1e-8;          // violations below are none
constexpr double kSlack = 4e-9;             // by which limits give way beyond the least violation, against 1 + it
constexpr double kSameViolation = 1e-7;
constexpr double kSameObjective = 1e-9;  // relative
constexpr double kNoObjective = 1e-14;   // absolute
constexpr double kLeastDual = 1e-12;
constexpr int kPolishPasses = 3;

double widen(double violation) {
  return violation > 0 ? violation + kSlack * (1 + violation) : 0;
}

}  // namespace

bool isBetter(const PieceMerit& a, const PieceMerit& b) {
  if (std::abs(a.row_violation - b.row_violation) > kSameViolation) return a.row_violation < b.row_violation;
  if (std::abs(a.soft_violation - b.soft_violation) > kSameViolation) return a.soft_violation < b.soft_violation;
  return a.objective < b.objective - kSameObjective * std::abs(b.objective) - kNoObjective;
}

PieceAnswer::PieceAnswer(const QpccSizes& capacity)
    : x(VecX::Zero(capacity.unknowns)), row(VecX::Zero(capacity.rows + capacity.contacts + capacity.effectors)) {
  candidates.reserve(static_cast<std::size_t>(capacity.contacts));
}

PieceQp::PieceQp(const QpccSizes& capacity)
    : qp_(capacity.unknowns, capacity.contacts + capacity.rows),
      elastic_qp_(capacity.unknowns + 1, 2 * (capacity.contacts + capacity.rows + capacity.unknowns)),
      limits_(capacity.contacts + capacity.rows + capacity.unknowns),
      elastic_limits_(2 * (capacity.contacts + capacity.rows) + 3 * capacity.unknowns + 1),
      G_(capacity.unknowns, capacity.unknowns),
      elastic_G_(capacity.unknowns + 1, capacity.unknowns + 1),
      elastic_map_(2 * (capacity.contacts + capacity.rows + capacity.unknowns), capacity.unknowns + 2),
      g_(capacity.unknowns),
      shifted_(capacity.unknowns),
      elastic_g_(capacity.unknowns + 1) {
  candidates_.reserve(3 * static_cast<std::size_t>(capacity.unknowns) + 3);
}

void PieceQp::attach(const ScaledQpcc& problem) {
  problem_ = &problem;
  updateLimits({});
}

void PieceQp::updateObjective(const Eigen::Ref<const MatX>& map) {
  const int n = problem_->size.unknowns;
  const auto E = map.middleRows(problem_->limitedRows(), problem_->size.effectors);
  double largest = 0;
  for (int j = 0; j < n; ++j) {
    for (int i = 0; i <= j; ++i) G_(i, j) = G_(j, i) = problem_->Q(i, j) + E.col(i).dot(E.col(j));
    g_(j) = problem_->q(j) + E.col(j).dot(E.col(n));
    largest = std::max(largest, G_(j, j));
  }
  ridge_ = kRidge * (largest > 0 ? largest : 1);
  G_.topLeftCorner(n, n).diagonal().array() += ridge_;
}

/// The limits, widened by the violations of `relaxation`.
void PieceQp::updateLimits(const PieceMerit& relaxation) {
  const ScaledQpcc& p = *problem_;
  const int n = p.size.unknowns;
  const int nc = p.size.contacts;
  const int nr = p.size.rows;
  const int m = p.limitedRows();
  const double rows = widen(relaxation.row_violation);
  const double soft = widen(relaxation.soft_violation);
  limits_.lower.head(m) = p.row_lower.head(m);
  limits_.upper.head(m) = p.row_upper.head(m);
  limits_.lower.segment(nc, nr).array() -= rows;
  limits_.upper.segment(nc, nr).array() += rows;
  limits_.lower.segment(m, n) = p.x_lower.head(n).cwiseMax(p.soft_lower.head(n) - soft * p.soft_range.head(n));
  limits_.upper.segment(m, n) = p.x_upper.head(n).cwiseMin(p.soft_upper.head(n) + soft * p.soft_range.head(n));
}

bool PieceQp::solve(const Eigen::Ref<const MatX>& map, PieceAnswer& answer) {
  answer.merit = {};
  candidates_.clear();
  return minimise(map, answer) && conclude(answer);
}

bool PieceQp::minimise(const Eigen::Ref<const MatX>& map, PieceAnswer& answer) {
  answer.valid = false;
  updateObjective(map);
  const int n = problem_->size.unknowns;
  const int m = problem_->limitedRows();
  if (!qp_.start(G_.topLeftCorner(n, n), g_.head(n))) return false;
  if (qp_.minimise(makeQpRows(map, m), limits_, kInfinity) != DualQp::Outcome::kOptimal) return false;
  answer.x.head(n) = qp_.x();
  const auto rows = map.bottomRows(map.rows() - problem_->size.contacts);
  answer.row.head(rows.rows()) = rows.col(n);
  answer.row.head(rows.rows()).noalias() += rows.leftCols(n) * qp_.x();
  answer.merit.objective = calcObjective(map, qp_.x());
  collectCandidates(qp_);
  return true;
}

bool PieceQp::solveElastic(const Eigen::Ref<const MatX>& map, PieceAnswer& answer) {
  PieceMerit& merit = answer.merit;
  merit = {};
  candidates_.clear();
  answer.valid = false;
  bool feasible = minimiseSoftViolation(map, merit);
  if (!feasible) {
    feasible = minimiseRowViolation(map, merit);
    if (feasible && merit.row_violation > 0) feasible = minimiseSoftViolation(map, merit);
  }
  updateLimits(merit);
  feasible = feasible && minimise(map, answer) && conclude(answer);
  updateLimits({});
  return feasible;
}

/// Unknowns (x, t): least t with x within its soft limits widened by t times their range.
bool PieceQp::minimiseSoftViolation(const Eigen::Ref<const MatX>& map, PieceMerit& merit) {
  const ScaledQpcc& p = *problem_;
  const int n = p.size.unknowns;
  const int m = p.limitedRows();
  updateLimits(merit);
  auto E = elastic_map_.topRows(m + 2 * n);
  E.leftCols(n).topRows(m) = map.leftCols(n).topRows(m);
  E.col(n).head(m).setZero();
  E.col(n + 1).head(m) = map.col(n).head(m);
  auto signs = E.leftCols(n).bottomRows(2 * n);
  signs.setZero();
  signs.topRows(n).diagonal().setConstant(1);
  signs.bottomRows(n).diagonal().setConstant(-1);
  E.col(n).segment(m, n) = p.soft_range.head(n);
  E.col(n).segment(m + n, n) = p.soft_range.head(n);
  E.col(n + 1).tail(2 * n).setZero();
  elastic_limits_.lower.head(m) = limits_.lower.head(m);
  elastic_limits_.upper.head(m) = limits_.upper.head(m);
  elastic_limits_.lower.segment(m, n) = p.soft_lower.head(n);
  elastic_limits_.lower.segment(m + n, n) = -p.soft_upper.head(n);
  elastic_limits_.upper.segment(m, 2 * n).setConstant(kInfinity);
  return minimiseViolation(m + 2 * n, merit.soft_violation);
}

/// Unknowns (x, t): least t with the limited rows within their limits widened by t, whatever the soft limits.
bool PieceQp::minimiseRowViolation(const Eigen::Ref<const MatX>& map, PieceMerit& merit) {
  const ScaledQpcc& p = *problem_;
  const int n = p.size.unknowns;
  const int nc = p.size.contacts;
  const int nr = p.size.rows;
  auto E = elastic_map_.topRows(nc + 2 * nr);
  const auto copy = [&](int column, int from) {
    E.col(column).head(nc + nr) = map.col(from).head(nc + nr);
    E.col(column).tail(nr) = -map.col(from).segment(nc, nr);
  };
  for (int j = 0; j < n; ++j) copy(j, j);
  copy(n + 1, n);
  E.col(n).head(nc).setZero();
  E.col(n).tail(2 * nr).setConstant(1);
  elastic_limits_.lower.head(nc + nr) = p.row_lower.head(nc + nr);
  elastic_limits_.lower.segment(nc + nr, nr) = -p.row_upper.segment(nc, nr);
  elastic_limits_.upper.head(nc + 2 * nr).setConstant(kInfinity);
  return minimiseViolation(nc + 2 * nr, merit.row_violation);
}

/// Least t + t^2 / 2, which has the minimiser of t; so little curvature in x leaves the minimiser of the linear program
/// where it is.
bool PieceQp::minimiseViolation(int rows, double& violation) {
  const int n = problem_->size.unknowns;
  auto G = elastic_G_.topLeftCorner(n + 1, n + 1);
  G.setZero();
  G.diagonal().head(n).setConstant(kElasticCurvature);
  G(n, n) = 1;
  elastic_g_.head(n).setZero();
  elastic_g_(n) = 1;
  elastic_limits_.lower.segment(rows, n) = problem_->x_lower.head(n);
  elastic_limits_.upper.segment(rows, n) = problem_->x_upper.head(n);
  elastic_limits_.lower(rows + n) = 0;
  elastic_limits_.upper(rows + n) = kInfinity;
  if (!elastic_qp_.start(G, elastic_g_.head(n + 1))) return false;
  const QpRows view = makeQpRows(elastic_map_.leftCols(n + 2), rows);
  if (elastic_qp_.minimise(view, elastic_limits_, kInfinity) != DualQp::Outcome::kOptimal) return false;
  const double t = elastic_qp_.x()(n);
  violation = t > kViolated ? t : 0;
  if (violation > 0) collectCandidates(elastic_qp_);
  return true;
}

/// The contacts among the active rows, behind those of earlier levels.
void PieceQp::collectCandidates(const DualQp& qp) {
  const std::size_t earlier = candidates_.size();
  for (int k = 0; k < qp.activeRows(); ++k)
    if (qp.activeRow(k) < problem_->size.contacts && qp.rowDual(k) > kLeastDual)
      candidates_.push_back({qp.activeRow(k), qp.rowDual(k)});
  std::sort(candidates_.begin() + static_cast<std::ptrdiff_t>(earlier), candidates_.end(),
            [](const Candidate& a, const Candidate& b) { return a.dual > b.dual; });
}

bool PieceQp::conclude(PieceAnswer& answer) {
  answer.candidates.clear();
  for (const Candidate& candidate : candidates_) {
    const auto known = std::find(answer.candidates.begin(), answer.candidates.end(), candidate.contact);
    if (known == answer.candidates.end()) answer.candidates.push_back(candidate.contact);
  }
  return answer.valid = std::isfinite(answer.merit.objective);
}

bool PieceQp::polish(const Eigen::Ref<const MatX>& map, const PieceMerit& merit, PieceAnswer& answer) {
  const int n = problem_->size.unknowns;
  const QpRows rows = makeQpRows(map, problem_->limitedRows());
  updateObjective(map);
  updateLimits(merit);
  shifted_.head(n) = g_.head(n);
  bool solved = true;
  // Proximal passes: the ridge pulls towards the last x instead of zero.
  for (int pass = 0; pass < kPolishPasses && solved; ++pass) {
    solved = qp_.start(G_.topLeftCorner(n, n), shifted_.head(n)) &&
             qp_.minimise(rows, limits_, kInfinity) == DualQp::Outcome::kOptimal;
    if (!solved) break;
    qp_.settle(rows, limits_);
    answer.x.head(n) = qp_.x();
    shifted_.head(n) = g_.head(n) - ridge_ * answer.x.head(n);
  }
  updateLimits({});
  answer.merit = merit;
  answer.merit.objective = solved ? calcObjective(map, answer.x.head(n)) : kInfinity;
  return answer.valid = std::isfinite(answer.merit.objective);
}

double PieceQp::calcObjective(const Eigen::Ref<const MatX>& map, const Eigen::Ref<const VecX>& x) const {
  const int n = problem_->size.unknowns;
  double sum = 0;
  for (int r = problem_->limitedRows(); r < problem_->tableRows(); ++r) {
    const double error = map.row(r).head(n).dot(x) + map(r, n);
    sum += error * error;
  }
  for (int j = 0; j < n; ++j) sum += x(j) * (problem_->Q.col(j).head(n).dot(x) + 2 * problem_->q(j));
  return 0.5 * sum;
}

}  // namespace sinew
