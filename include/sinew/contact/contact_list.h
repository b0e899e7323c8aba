#pragma once

#include <cstdint>
#include <limits>
#include <vector>

#include "sinew/common/types.h"

namespace sinew {

enum class ContactMethod { kProximity, kVolume };

/// In place of an obstacle's index: the robot against itself, or against another soft surface.
constexpr int kSelfContact = -1;
constexpr int kOtherSurface = -2;

/// d gap / d position of one node.
struct ContactEntry {
  int surface;  ///< 0: the robot's surface; 1: the other one, where two deformable surfaces meet
  int node;     ///< index into the node positions of that surface
  Vec3 gradient;
};

/// One inequality gap >= 0.
struct ContactRow {
  std::uint64_t key = 0;            ///< names the pair of features: the same pair has the same key in every cycle
  int obstacle = kSelfContact;      ///< index, kSelfContact or kOtherSurface
  Vec3 point = Vec3::Zero();        ///< on the robot [m]
  Vec3 other_point = Vec3::Zero();  ///< on the obstacle, or on the other part of the robot [m]
  Vec3 normal = Vec3::UnitZ();      ///< unit, from the obstacle towards the robot
  double gap = 0;                   ///< m, distance minus contact distance: negative where the row is violated
  double area = 0;                  ///< m2 of the robot's surface that the row stands for
  ContactMethod method = ContactMethod::kProximity;
  int first_entry = 0;
  int entries = 0;
};

/// The contacts of one cycle in room that is fixed at set-up, sorted by key. A cycle is `begin`, any number of `add`,
/// `finish`. The keys of the cycle before are remembered, so that those who add can hold on to a contact for a little
/// longer than they would take up a new one. Nothing allocates after construction.
class ContactList {
 public:
  ContactList(int max_rows, int max_entries);

  void begin();
  /// Copies `row` with its `count` entries. Without room the rows of largest gap give way: to `row` or with it.
  void add(const ContactRow& row, const ContactEntry* entries, int count);
  /// Sorts by key, and of rows that coincide in both points and normal keeps one: that of the cycle before, else the
  /// smallest key.
  void finish();

  int size() const { return static_cast<int>(rows_.size()); }
  const ContactRow& row(int i) const { return rows_[i]; }
  const ContactEntry* entries(int i) const { return entries_.data() + rows_[i].first_entry; }
  int entryCount() const { return static_cast<int>(entries_.size()); }
  /// Whether the finished cycle before this one had a row of this key.
  bool hadRow(std::uint64_t key) const;
  /// Rows that found no room since `begin`.
  int dropped() const { return dropped_; }
  double leastDroppedGap() const { return least_dropped_gap_; }  ///< m, of these rows; infinite without any

 private:
  int findWidest() const;
  void remove(int row);
  void mergeCoinciding();

  int max_rows_, max_entries_;
  int dropped_ = 0;
  double least_dropped_gap_ = std::numeric_limits<double>::infinity();
  std::vector<ContactRow> rows_;
  std::vector<ContactEntry> entries_;
  std::vector<std::uint64_t> previous_;
  std::vector<char> doubled_;
};

}  // namespace sinew
