#include "sinew/solver/complementarity_tableau.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

constexpr int kMaxRefinements = 4;
constexpr double kRefined = 1e-12;  // gap left to active contacts, relative to the largest entry

/// A key per contact, spread over all bits (the finaliser of SplitMix64).
std::uint64_t calcKey(int contact) {
  std::uint64_t key = 0x9e3779b97f4a7c15u * (static_cast<std::uint64_t>(contact) + 1);
  key = (key ^ (key >> 30)) * 0xbf58476d1ce4e5b9u;
  key = (key ^ (key >> 27)) * 0x94d049bb133111ebu;
  return key ^ (key >> 31);
}

/// Even, so that all columns are aligned alike.
int roundUp(int rows) {
  return (rows + 3) / 4 * 4;
}

}  // namespace

ComplementarityTableau::ComplementarityTableau(const QpccSizes& capacity, InstructionSet set)
    : kernels_(&denseKernelsOf(set)),
      table_(roundUp(capacity.contacts + capacity.rows + capacity.effectors),
             capacity.contacts + capacity.unknowns + 1),
      pivot_column_(table_.rows()),
      pivot_row_(table_.cols()),
      gap_(capacity.contacts),
      active_(static_cast<std::size_t>(capacity.contacts), 0),
      wanted_(static_cast<std::size_t>(capacity.contacts), 0),
      listed_(static_cast<std::size_t>(capacity.contacts), 0) {}

void ComplementarityTableau::reset(const ScaledQpcc& problem) {
  problem_ = &problem;
  const int rows = problem.tableRows();
  const int columns = problem.tableColumns();
  table_.topLeftCorner(rows, columns) = problem.table.topLeftCorner(rows, columns);
  table_.topLeftCorner(problem.size.contacts, problem.size.contacts).diagonal().array() += kLift;
  std::fill(active_.begin(), active_.end(), 0);
  active_count_ = 0;
  hash_ = 0;
}

void ComplementarityTableau::swapRowAndColumn(int row, int column) {
  const int rows = problem_->tableRows();
  const int columns = problem_->tableColumns();
  auto swapped = table_.col(column).head(rows);
  auto pivot_column = pivot_column_.head(rows);
  auto factors = pivot_row_.head(columns);
  pivot_column = swapped;
  const double inverse = 1 / pivot_column(row);
  factors = inverse * table_.row(row).head(columns).transpose();
  factors(column) = 0;
  kernels_->subtractOuter(table_.data(), static_cast<int>(table_.outerStride()), rows, pivot_column.data(),
                          factors.data(), columns);
  table_.row(row).head(columns) = -factors.transpose();
  swapped = inverse * pivot_column;
  swapped(row) = inverse;
}

void ComplementarityTableau::pivot(int contact) {
  swapRowAndColumn(contact, contact);
  char& active = active_[static_cast<std::size_t>(contact)];
  active = active ? 0 : 1;
  active_count_ += active ? 1 : -1;
  hash_ ^= calcKey(contact);
}

std::uint64_t ComplementarityTableau::hashAfter(int contact) const {
  return hash_ ^ calcKey(contact);
}

void ComplementarityTableau::exchange(int row, int unknown) {
  swapRowAndColumn(problem_->size.contacts + row, problem_->size.contacts + unknown);
}

void ComplementarityTableau::moveTo(const std::vector<char>& active) {
  const int n = problem_->size.contacts;
  int moves = 0;
  int wanted = 0;
  for (int i = 0; i < n; ++i) {
    wanted_[static_cast<std::size_t>(i)] = active[static_cast<std::size_t>(i)];
    moves += wanted_[static_cast<std::size_t>(i)] != active_[static_cast<std::size_t>(i)];
    wanted += wanted_[static_cast<std::size_t>(i)];
  }
  if (moves > wanted) reset(*problem_);
  for (int i = 0; i < n; ++i)
    if (wanted_[static_cast<std::size_t>(i)] != active_[static_cast<std::size_t>(i)]) pivot(i);
}

void ComplementarityTableau::rebuild(const std::vector<char>& active) {
  std::copy(active.begin(), active.end(), wanted_.begin());
  const auto count = std::count(wanted_.begin(), wanted_.begin() + problem_->size.contacts, 1);
  reset(*problem_);
  // The largest pivot first, which loses least.
  for (std::ptrdiff_t step = 0; step < count; ++step) {
    int best = -1;
    for (int i = 0; i < problem_->size.contacts; ++i) {
      if (!wanted_[static_cast<std::size_t>(i)] || isActive(i)) continue;
      if (best < 0 || table_(i, i) > table_(best, best)) best = i;
    }
    pivot(best);
  }
}

double ComplementarityTableau::calcDrift() const {
  const int constants = problem_->size.contacts + problem_->size.unknowns;
  double worst = 0;
  for (int i = 0; i < problem_->size.contacts; ++i) {
    if (!isActive(i)) continue;
    double gap = problem_->table(i, constants);
    double terms = std::abs(gap);
    for (int k = 0; k < problem_->size.contacts; ++k) {
      if (!isActive(k)) continue;
      const double term = (problem_->table(i, k) + (i == k ? kLift : 0)) * table_(k, constants);
      gap += term;
      terms += std::abs(term);
    }
    if (!(std::abs(gap) <= worst * terms)) worst = std::abs(gap) / terms;
  }
  return worst;
}

bool ComplementarityTableau::refine(Eigen::Ref<MatX> map) {
  const int nc = problem_->size.contacts;
  const int rows = problem_->tableRows();
  int count = 0;
  for (int i = 0; i < nc; ++i)
    if (isActive(i)) listed_[static_cast<std::size_t>(count++)] = i;
  const auto activeAt = [this](int k) { return listed_[static_cast<std::size_t>(k)]; };

  for (int j = 0; j <= problem_->size.unknowns; ++j) {
    const auto original = problem_->table.col(nc + j).head(rows);
    auto force = map.col(j).head(rows);
    force = table_.col(nc + j).head(rows);
    double left = count > 0 ? 1 : 0;
    for (int pass = 0; pass < kMaxRefinements && left > 0.1 * kRefined; ++pass) {
      left = 0;
      for (int r = 0; r < count; ++r) {
        double gap = original(activeAt(r));
        for (int k = 0; k < count; ++k) gap += problem_->table(activeAt(r), activeAt(k)) * force(activeAt(k));
        gap_(r) = gap;
        left = std::max(left, std::abs(gap));
      }
      for (int r = 0; r < count; ++r)
        for (int k = 0; k < count; ++k) force(activeAt(r)) -= table_(activeAt(r), activeAt(k)) * gap_(k);
    }
    if (!(left <= kRefined * std::max(1.0, original.head(nc).lpNorm<Eigen::Infinity>()))) return false;

    pivot_column_.head(rows) = original;
    for (int k = 0; k < count; ++k)
      pivot_column_.head(rows) += problem_->table.col(activeAt(k)).head(rows) * force(activeAt(k));
    for (int i = 0; i < rows; ++i)
      if (i >= nc || !isActive(i)) force(i) = pivot_column_(i);
  }
  return true;
}

}  // namespace sinew
