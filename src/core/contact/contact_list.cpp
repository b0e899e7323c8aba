#include "sinew/contact/contact_list.h"

#include <algorithm>

#include "sinew/common/config_error.h"

namespace sinew {
namespace {

constexpr double kSamePoint = 1e-6;   // m
constexpr double kSameNormal = 1e-6;  // 1 - cosine

bool coincide(const ContactRow& a, const ContactRow& b) {
  return a.obstacle == b.obstacle && a.method == b.method &&
         (a.point - b.point).squaredNorm() < kSamePoint * kSamePoint &&
         (a.other_point - b.other_point).squaredNorm() < kSamePoint * kSamePoint &&
         a.normal.dot(b.normal) > 1 - kSameNormal;
}

/// Of two gaps alike that of the greater key, so that what is kept does not depend on the order in which rows come.
bool isWider(const ContactRow& a, const ContactRow& b) {
  return a.gap > b.gap || (a.gap == b.gap && a.key > b.key);
}

}  // namespace

ContactList::ContactList(int max_rows, int max_entries) : max_rows_(max_rows), max_entries_(max_entries) {
  if (max_rows < 1) throw ConfigError("contact list: rows", std::to_string(max_rows), "at least 1");
  if (max_entries < max_rows) {
    throw ConfigError("contact list: entries", std::to_string(max_entries), "at least one for each row");
  }
  rows_.reserve(max_rows);
  entries_.reserve(max_entries);
  previous_.reserve(max_rows);
  doubled_.reserve(max_rows);
}

void ContactList::begin() {
  previous_.clear();
  for (const ContactRow& row : rows_) previous_.push_back(row.key);
  rows_.clear();
  entries_.clear();
  dropped_ = 0;
  least_dropped_gap_ = std::numeric_limits<double>::infinity();
}

bool ContactList::hadRow(std::uint64_t key) const {
  return std::binary_search(previous_.begin(), previous_.end(), key);
}

void ContactList::add(const ContactRow& row, const ContactEntry* entries, int count) {
  while (size() == max_rows_ || entryCount() + count > max_entries_) {
    ++dropped_;
    const int widest = findWidest();
    const bool gives_way = widest >= 0 && isWider(rows_[widest], row);
    least_dropped_gap_ = std::min(least_dropped_gap_, gives_way ? rows_[widest].gap : row.gap);
    if (!gives_way) return;
    remove(widest);
  }
  rows_.push_back(row);
  rows_.back().first_entry = entryCount();
  rows_.back().entries = count;
  entries_.insert(entries_.end(), entries, entries + count);
}

int ContactList::findWidest() const {
  const auto widest = std::max_element(rows_.begin(), rows_.end(),
                                       [](const ContactRow& a, const ContactRow& b) { return isWider(b, a); });
  return widest == rows_.end() ? -1 : static_cast<int>(widest - rows_.begin());
}

void ContactList::remove(int row) {
  const int first = rows_[row].first_entry;
  const int count = rows_[row].entries;
  entries_.erase(entries_.begin() + first, entries_.begin() + first + count);
  rows_.erase(rows_.begin() + row);
  for (ContactRow& other : rows_) {
    if (other.first_entry > first) other.first_entry -= count;
  }
}

void ContactList::finish() {
  std::sort(rows_.begin(), rows_.end(), [](const ContactRow& a, const ContactRow& b) { return a.key < b.key; });
  mergeCoinciding();
}

void ContactList::mergeCoinciding() {
  doubled_.assign(rows_.size(), 0);
  for (int i = 0; i < size(); ++i) {
    for (int j = i + 1; j < size() && !doubled_[i]; ++j) {
      if (doubled_[j] || !coincide(rows_[i], rows_[j])) continue;
      const bool later_was_there = !hadRow(rows_[i].key) && hadRow(rows_[j].key);
      doubled_[later_was_there ? i : j] = 1;
    }
  }
  int kept = 0;
  for (int i = 0; i < size(); ++i) {
    if (!doubled_[i]) rows_[kept++] = rows_[i];
  }
  rows_.resize(kept);
}

}  // namespace sinew
