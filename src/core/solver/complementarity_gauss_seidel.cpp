#include "sinew/solver/complementarity_gauss_seidel.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

namespace sinew {
namespace {

constexpr double kRounding = 1e-13;  // of the largest entries, within which a sign is not wrong
constexpr double kExact = 1e-15;     // likewise, of what should be zero
constexpr int kFirstSweeps = 2;
constexpr int kSweeps = 20;
constexpr int kRounds = 3;
constexpr int kExchanges = 40;
constexpr int kPatience = 3;  // exchanges without progress
constexpr int kDescents = 300;
constexpr int kRefinements = 3;

// A NaN or an infinity anywhere ends up in the sum.
bool isFinite(const ComplementarityProblem& problem) {
  const int n = problem.size;
  return n == 0 || std::isfinite(problem.A.topLeftCorner(n, n).sum() + problem.b.head(n).sum());
}

bool factorise(Eigen::Ref<MatX> matrix) {
  const Eigen::LLT<Eigen::Ref<MatX>> cholesky(matrix);
  return cholesky.info() == Eigen::Success;
}

template <typename Factor>
void solveInPlace(const Factor& factor, Eigen::Ref<VecX> right) {
  const auto lower = factor.template triangularView<Eigen::Lower>();
  lower.solveInPlace(right);
  lower.transpose().solveInPlace(right);
}

}  // namespace

ComplementarityProblem::ComplementarityProblem(int max_size)
    : A(MatX::Zero(max_size, max_size)), b(VecX::Zero(max_size)), equality(static_cast<std::size_t>(max_size), 0) {}

ComplementarityGaussSeidel::ComplementarityGaussSeidel(int max_size)
    : x_(max_size),
      value_(max_size),
      swept_(max_size),
      lifted_(max_size),
      step_(max_size),
      block_factor_(max_size, max_size),
      active_factor_(max_size, max_size),
      active_(static_cast<std::size_t>(max_size), 0) {
  list_.reserve(static_cast<std::size_t>(max_size));
}

ComplementarityStatus ComplementarityGaussSeidel::solve(const ComplementarityProblem& problem, Eigen::Ref<VecX> x) {
  if (!isFinite(problem)) return ComplementarityStatus::kNotFinite;
  start(problem, x);
  bool solved = size_ == 0;
  for (int round = 0; round < kRounds && !solved; ++round) {
    const int count = round == 0 ? kFirstSweeps : kSweeps;
    for (int k = 0; k < count; ++k) sweep();
    solved = finishExactly();
  }
  if (!x_.head(size_).allFinite() || !value().allFinite()) return ComplementarityStatus::kNotFinite;
  if (!solved) return ComplementarityStatus::kNotConverged;
  x = x_.head(size_);
  return ComplementarityStatus::kSolved;
}

void ComplementarityGaussSeidel::start(const ComplementarityProblem& problem, const Eigen::Ref<const VecX>& x) {
  problem_ = &problem;
  size_ = problem.size;
  direct_solves_ = 0;
  for (int i = 0; i < size_; ++i) x_[i] = problem.equality[i] ? x[i] : std::max(0.0, x[i]);
  updateValue();
  const int n = problem.block;
  block_factor_.topLeftCorner(n, n) = problem.A.topLeftCorner(n, n);
  block_factor_.diagonal().head(n).array() += kLift;
  has_block_ = n > 0 && factorise(block_factor_.topLeftCorner(n, n));
}

// The block as a whole where that leaves it no wrong sign, otherwise its rows one by one: either lowers the objective
// 1/2 x^T A x + b^T x.
void ComplementarityGaussSeidel::sweep() {
  const bool together = has_block_ && moveBlock();
  for (int i = together ? problem_->block : 0; i < size_; ++i) moveRow(i);
}

bool ComplementarityGaussSeidel::moveBlock() {
  const int n = problem_->block;
  auto step = step_.head(n);
  step = -(value_.head(n) + kLift * x_.head(n));
  solveInPlace(block_factor_.topLeftCorner(n, n), step);
  for (int i = 0; i < n; ++i) {
    if (!problem_->equality[i] && x_[i] + step[i] < 0) return false;
  }
  for (int i = 0; i < n; ++i) move(i, step[i]);
  return true;
}

void ComplementarityGaussSeidel::moveRow(int i) {
  const double step = -(value_[i] + kLift * x_[i]) / (problem_->A(i, i) + kLift);
  move(i, problem_->equality[i] ? step : std::max(step, -x_[i]));
}

void ComplementarityGaussSeidel::move(int i, double step) {
  if (step == 0) return;
  x_[i] += step;
  value_.head(size_).noalias() += step * problem_->A.col(i).head(size_);
}

bool ComplementarityGaussSeidel::finishExactly() {
  swept_.head(size_) = x_.head(size_);
  if (exchange() || descend()) return true;
  x_.head(size_) = swept_.head(size_);
  updateValue();
  return false;
}

bool ComplementarityGaussSeidel::exchange() {
  markActive();
  int fewest = size_ + 1, patience = kPatience;
  for (int k = 0; k < kExchanges && patience > 0 && solveActive(); ++k) {
    const bool exact = refine();
    const int count = exchangeWrong();
    if (count == 0) {
      accept(exact ? x_ : lifted_);
      return true;
    }
    patience = count < fewest ? kPatience : patience - 1;
    fewest = std::min(fewest, count);
  }
  return false;
}

// Towards the answer of the active rows as far as no sign turns, and there with the worst row more: the objective falls
// with every step, which ends.
bool ComplementarityGaussSeidel::descend() {
  x_.head(size_) = swept_.head(size_);
  markActive();
  for (int k = 0; k < kDescents && solveActive(); ++k) {
    const bool exact = refine();
    if (stopAtZero()) continue;
    const int worst = findWorst();
    if (worst < 0) {
      accept(exact ? x_ : lifted_);
      return true;
    }
    active_[worst] = true;
  }
  return false;
}

// From `swept_` towards `x_` as far as signs allow; rows that come to zero leave the active ones. False when all of the
// way is free.
bool ComplementarityGaussSeidel::stopAtZero() {
  const double rounding = kRounding * calcLargest();
  double part = 1;
  for (int i : list_) {
    if (wrong(i, rounding)) part = std::min(part, swept_[i] / (swept_[i] - x_[i]));
  }
  for (int i : list_) {
    const bool ends = wrong(i, rounding) && swept_[i] <= part * (swept_[i] - x_[i]) * (1 + kRounding);
    swept_[i] = ends ? 0 : swept_[i] + part * (x_[i] - swept_[i]);
    if (ends) active_[i] = false;
  }
  return part < 1;
}

int ComplementarityGaussSeidel::findWorst() const {
  const double rounding = kRounding * calcLargest();
  int worst = -1;
  for (int i = 0; i < size_; ++i) {
    if (!active_[i] && wrong(i, rounding) && (worst < 0 || value_[i] < value_[worst])) worst = i;
  }
  return worst;
}

void ComplementarityGaussSeidel::accept(const VecX& x) {
  for (int i = 0; i < size_; ++i) x_[i] = problem_->equality[i] ? x[i] : std::max(0.0, x[i]);
  updateValue();
}

void ComplementarityGaussSeidel::markActive() {
  for (int i = 0; i < size_; ++i) active_[i] = problem_->equality[i] || x_[i] > 0;
}

bool ComplementarityGaussSeidel::solveActive() {
  ++direct_solves_;
  list_.clear();
  for (int i = 0; i < size_; ++i) {
    if (active_[i]) list_.push_back(i);
  }
  const int n = active_count_ = static_cast<int>(list_.size());
  for (int j = 0; j < n; ++j) {
    for (int i = j; i < n; ++i) active_factor_(i, j) = problem_->A(list_[i], list_[j]);
    active_factor_(j, j) += kLift;
    step_[j] = -problem_->b[list_[j]];
  }
  if (!factorise(active_factor_.topLeftCorner(n, n))) return false;
  solveInPlace(active_factor_.topLeftCorner(n, n), step_.head(n));
  x_.head(size_).setZero();
  for (int j = 0; j < n; ++j) x_[list_[j]] = step_[j];
  updateValue();
  return true;
}

// Takes the lift out of the answer; false where rows contradict each other, so that there is none without it.
bool ComplementarityGaussSeidel::refine() {
  lifted_.head(size_) = x_.head(size_);
  for (int k = 0; k < kRefinements && calcResidual() > kExact * calcLargest(); ++k) {
    for (int j = 0; j < active_count_; ++j) step_[j] = value_[list_[j]];
    solveInPlace(active_factor_.topLeftCorner(active_count_, active_count_), step_.head(active_count_));
    for (int j = 0; j < active_count_; ++j) x_[list_[j]] -= step_[j];
    updateValue();
  }
  return calcResidual() <= kRounding * calcLargest();
}

double ComplementarityGaussSeidel::calcResidual() const {
  double residual = 0;
  for (int i : list_) residual = std::max(residual, std::abs(value_[i]));
  return residual;
}

void ComplementarityGaussSeidel::updateValue() {
  value_.head(size_) = problem_->b.head(size_);
  for (int i = 0; i < size_; ++i) {
    if (x_[i] != 0) value_.head(size_).noalias() += x_[i] * problem_->A.col(i).head(size_);
  }
}

double ComplementarityGaussSeidel::calcLargest() const {
  return x_.head(size_).cwiseAbs().maxCoeff() + problem_->b.head(size_).cwiseAbs().maxCoeff();
}

bool ComplementarityGaussSeidel::wrong(int i, double rounding) const {
  return !problem_->equality[i] && (active_[i] ? x_[i] : value_[i]) < -rounding;
}

int ComplementarityGaussSeidel::exchangeWrong() {
  const double rounding = kRounding * calcLargest();
  int count = 0;
  for (int i = 0; i < size_; ++i) {
    if (!wrong(i, rounding)) continue;
    active_[i] = !active_[i];
    ++count;
  }
  return count;
}

}  // namespace sinew
