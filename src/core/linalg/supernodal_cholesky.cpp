#include "sinew/linalg/supernodal_cholesky.h"

#include <algorithm>
#include <cassert>

#include "sinew/linalg/panel_shares.h"

namespace sinew {
namespace {

constexpr int kVector = 8;         // doubles in the widest vector
constexpr int kBits = 64;          // groups of rows
constexpr int kReadBeyond = 32;    // doubles that whole vectors may read past an end
constexpr int kWideColumns = 9;    // of the widest tile
constexpr int kManyEntries = 16;   // a row with more reaches over much of the body
constexpr int kProductDepth = 64;  // columns of half solutions that fit the nearest cache

int padded(int count, int to) {
  return (count + to - 1) / to * to;
}

}  // namespace

SupernodalCholesky::SupernodalCholesky(const FactorPattern& pattern, int max_rows, int threads, InstructionSet set)
    : pattern_(&pattern),
      kernels_(&kernelsOf(set)),
      team_(threads),
      shares_(static_cast<std::size_t>(threads)),
      trunk_shares_(static_cast<std::size_t>(threads)),
      owner_(pattern.panels().size(), 0),
      values_(static_cast<std::size_t>(pattern.valueCount() + kReadBeyond), 0.0),
      inverse_diagonal_(static_cast<std::size_t>(pattern.size())),
      half_stride_(padded(max_rows + 1, kVector)),
      group_(kVector),
      active_(pattern.panels().size(), 0),
      was_active_(pattern.panels().size(), 0),
      place_(static_cast<std::size_t>(max_rows)),
      keys_(static_cast<std::size_t>(max_rows)) {
  while (half_stride_ > kBits * group_) group_ += kVector;
  half_stride_ = padded(half_stride_, group_);
  if (half_stride_ / kVector % 2 == 0) half_stride_ += kVector;  // an odd number of cache lines
  force_.assign(static_cast<std::size_t>(half_stride_), 0.0);
  PanelShares dealt = makePanelShares(pattern, threads);
  trunk_ = std::move(dealt.trunk);
  for (std::size_t k = 0; k < trunk_.size(); ++k) {
    trunk_shares_[k * trunk_shares_.size() / trunk_.size()].push_back(trunk_[k]);
  }
  for (std::size_t t = 0; t < shares_.size(); ++t) {
    Share& share = shares_[t];
    share.panels = std::move(dealt.branches[t]);
    share.half.assign(static_cast<std::size_t>(half_stride_) * pattern.size() + kReadBeyond, 0.0);
    share.gram.assign(static_cast<std::size_t>(half_stride_) * (half_stride_ + kWideColumns) + kReadBeyond, 0.0);
    share.gathered.assign(static_cast<std::size_t>(pattern.size()) + kReadBeyond, 0.0);
    for (const int panel : share.panels) owner_[panel] = static_cast<int>(t);
  }
}

bool SupernodalCholesky::factorise(const BlockMatrix& matrix) {
  team_.run([&](int member) {
    Share& share = shares_[member];
    share.positive = factorise(share.panels, matrix);
  });
  return std::all_of(shares_.begin(), shares_.end(), [](const Share& share) { return share.positive; }) &&
         factorise(trunk_, matrix);
}

// Behind what is taken from it: beside its large entries each part of that would be rounded more.
void SupernodalCholesky::add(const BlockMatrix& matrix, const Panel& panel) {
  const std::vector<int>& start = matrix.pattern().columnStart();
  double* column = values_.data() + panel.values;
  for (int j = panel.first; j < panel.first + panel.own; ++j) {
    const double* value = matrix.values().data() + 9 * start[j];
    for (int c = 0; c < 3; ++c, column += panel.stride) {
      for (int k = start[j]; k < start[j + 1]; ++k, value += 3) {
        double* to = column + pattern_->matrixPlaces()[k];
        for (int d = 0; d < 3; ++d) to[d] += value[d];
      }
    }
  }
}

bool SupernodalCholesky::factorise(const std::vector<int>& panels, const BlockMatrix& matrix) {
  double* values = values_.data();
  for (const int p : panels) {
    const Panel& panel = pattern_->panels()[p];
    std::fill_n(values + panel.values, panel.columns() * panel.stride, 0.0);
    for (const auto* update = pattern_->updatesBegin(p); update != pattern_->updatesEnd(p); ++update) {
      const Panel& source = pattern_->panels()[update->source];
      kernels_->update(values + source.values + 3 * (source.own + update->first_row), source.stride, source.columns(),
                       pattern_->places().data() + update->place, source.below_count - update->first_row,
                       update->column_count, values + panel.values, panel.stride);
    }
    add(matrix, panel);
    if (!kernels_->factorise(values + panel.values, panel.stride, panel.columns(), panel.rows(),
                             inverse_diagonal_.data() + 3 * panel.first)) {
      return false;
    }
  }
  return true;
}

// Rows that reach over much of the body first, the others by the panel they begin in: those in one group then have much
// of their paths in common.
void SupernodalCholesky::sortRows(const BlockRows& H) {
  rows_ = H.rows();
  assert(rows_ <= static_cast<int>(place_.size()));
  for (int row = 0; row < rows_; ++row) {
    int first = static_cast<int>(active_.size());
    for (const auto* entry = H.begin(row); entry != H.end(row); ++entry) {
      first = std::min(first, pattern_->panelOf(entry->block));
    }
    const bool wide = H.end(row) - H.begin(row) > kManyEntries;
    keys_[row] = {wide ? -1 : first, row};
  }
  std::sort(keys_.begin(), keys_.begin() + rows_,
            [](const Key& a, const Key& b) { return a.order != b.order ? a.order < b.order : a.row < b.row; });
  for (int k = 0; k < rows_; ++k) place_[keys_[k].row] = k + 1;
}

void SupernodalCholesky::findActive(const BlockRows& H) {
  active_.swap(was_active_);
  std::fill(active_.begin(), active_.end(), groupOf(0));
  for (int row = 0; row < rows_; ++row) {
    const Groups bit = groupOf(place_[row]);
    for (const auto* entry = H.begin(row); entry != H.end(row); ++entry)
      active_[pattern_->panelOf(entry->block)] |= bit;
  }
  for (std::size_t p = 0; p < active_.size(); ++p) {
    const int parent = pattern_->panels()[p].parent;
    if (parent >= 0) active_[parent] |= active_[p];
  }
}

void SupernodalCholesky::clear(Share& share, const std::vector<int>& panels) {
  for (const int p : panels) {
    const Panel& panel = pattern_->panels()[p];
    const Groups used = active_[p] | was_active_[p];
    double* first = share.column(3 * panel.first, half_stride_);
    for (int begin = 0, end = 0; begin < half_stride_; begin = end + group_) {  // runs of used groups
      for (end = begin; end < half_stride_ && (used & groupOf(end)) != 0; end += group_) {
      }
      const int length = std::min(end, half_stride_) - begin;
      for (int c = 0; c < panel.columns() && length > 0; ++c)
        std::fill_n(first + c * half_stride_ + begin, length, 0.0);
    }
  }
}

void SupernodalCholesky::scatter(const BlockRows& H, const VecX& load, int owner) {
  Share& share = shares_[owner];
  for (int block = 0; block < load.size() / 3; ++block) {
    if (owner_[pattern_->panelOf(block)] != owner) continue;
    for (int d = 0; d < 3; ++d) *share.column(3 * block + d, half_stride_) = load[3 * block + d];
  }
  for (int row = 0; row < rows_; ++row) {
    for (const auto* entry = H.begin(row); entry != H.end(row); ++entry) {
      if (owner_[pattern_->panelOf(entry->block)] != owner) continue;
      double* value = share.column(3 * entry->block, half_stride_) + place_[row];
      for (int d = 0; d < 3; ++d) value[d * half_stride_] += entry->derivative[d];
    }
  }
}

void SupernodalCholesky::substitute(Share& share, const std::vector<int>& panels, Groups groups) {
  for (const int p : panels) {
    const Panel& panel = pattern_->panels()[p];
    kernels_->forward(values_.data() + panel.values, panel.stride, panel.columns(),
                      inverse_diagonal_.data() + 3 * panel.first, pattern_->below().data() + panel.below_begin,
                      panel.below_count, share.half.data(), half_stride_, 3 * panel.first, active_[p] & groups, group_);
  }
}

// Panels whose columns lie together are multiplied together, as far as the cache goes.
void SupernodalCholesky::multiply(Share& share, const std::vector<int>& panels) {
  Share& source = &panels == &share.panels ? share : shares_.front();  // where these half solutions are
  for (std::size_t k = 0; k < panels.size();) {
    const int first = 3 * pattern_->panels()[panels[k]].first;
    int depth = 0;
    Groups groups = 0;
    for (const int begin = panels[k]; k < panels.size() && depth < kProductDepth; ++k) {
      const Panel& panel = pattern_->panels()[panels[k]];
      if (3 * panel.first != first + depth || panels[k] < begin) break;
      depth += panel.columns();
      groups |= active_[panels[k]];
    }
    kernels_->product(source.column(first, half_stride_), half_stride_, depth, groups, group_, share.gram.data(),
                      half_stride_);
  }
}

SupernodalCholesky::Groups SupernodalCholesky::groupsOf(int member) const {
  const int count = groupCount(), first = count * member / team_.size(), end = count * (member + 1) / team_.size();
  Groups groups = 0;
  for (int bit = first; bit < end; ++bit) groups |= Groups{1} << static_cast<unsigned>(bit);
  return groups;
}

// Brings together, for one thread's rows, what all branches add to the trunk, and goes on through it.
void SupernodalCholesky::joinTrunk(int member) {
  const Groups groups = groupsOf(member);
  for (const int p : trunk_) {
    const Panel& panel = pattern_->panels()[p];
    for (int c = 3 * panel.first; c < 3 * panel.first + panel.columns(); ++c) {
      double* sum = shares_.front().column(c, half_stride_);
      for (int begin = 0; begin < half_stride_; begin += group_) {
        if ((active_[p] & groups & groupOf(begin)) == 0) continue;
        const int end = std::min(begin + group_, half_stride_);
        for (std::size_t t = 1; t < shares_.size(); ++t) {
          const double* part = shares_[t].column(c, half_stride_);
          for (int i = begin; i < end; ++i) sum[i] += part[i];
        }
      }
    }
  }
  substitute(shares_.front(), trunk_, groups);
}

void SupernodalCholesky::condense(const BlockRows& H, const VecX& load, Eigen::Ref<MatX> compliance,
                                  Eigen::Ref<VecX> motion) {
  sortRows(H);
  findActive(H);
  team_.run([&](int member) {
    Share& share = shares_[member];
    clear(share, share.panels);
    clear(share, trunk_);
    scatter(H, load, member);
    substitute(share, share.panels, ~Groups{0});
    std::fill_n(share.gram.begin(), half_stride_ * (rows_ + 1 + kWideColumns), 0.0);
    multiply(share, share.panels);
  });
  if (!trunk_.empty()) {
    team_.run([&](int member) { joinTrunk(member); });
    team_.run([&](int member) { multiply(shares_[member], trunk_shares_[member]); });
  }
  gather(compliance, motion);
}

// The sum of the threads' products, back in the order of the rows.
void SupernodalCholesky::gather(Eigen::Ref<MatX> compliance, Eigen::Ref<VecX> motion) {
  for (int low = 0; low <= rows_; ++low) {
    double* column = shares_.front().gram.data() + low * half_stride_;
    for (std::size_t t = 1; t < shares_.size(); ++t) {
      const double* other = shares_[t].gram.data() + low * half_stride_;
      for (int high = low; high <= rows_; ++high) column[high] += other[high];
    }
    for (int high = std::max(low, 1); high <= rows_; ++high) {
      const int row = keys_[high - 1].row;
      if (low == 0) {
        motion[row] = -column[high];
      } else {
        const int other = keys_[low - 1].row;
        compliance(row, other) = compliance(other, row) = -column[high];
      }
    }
  }
}

void SupernodalCholesky::calcMotion(const VecX& force, VecX& x) {
  std::fill(force_.begin(), force_.end(), 0.0);
  force_[0] = 1;
  for (int row = 0; row < rows_; ++row) force_[place_[row]] = force[row];
  substituteBackward(trunk_, shares_.front(), x.data());
  team_.run([&](int member) { substituteBackward(shares_[member].panels, shares_[member], x.data()); });
}

void SupernodalCholesky::substituteBackward(const std::vector<int>& panels, Share& share, double* x) {
  for (auto p = panels.rbegin(); p != panels.rend(); ++p) {
    const Panel& panel = pattern_->panels()[*p];
    const int first = 3 * panel.first;
    kernels_->combine(share.column(first, half_stride_), half_stride_, active_[*p], group_, force_.data(),
                      panel.columns(), x + first);
    kernels_->backward(values_.data() + panel.values, panel.stride, panel.columns(), inverse_diagonal_.data() + first,
                       pattern_->below().data() + panel.below_begin, panel.below_count, x, first,
                       share.gathered.data());
  }
}

}  // namespace sinew
