#pragma once

#include <cstdint>
#include <vector>

namespace sinew {

/// The active sets a search has seen, by their hashes. Two sets with one hash would cost a piece of the search, never
/// its correctness. Nothing allocates after construction.
class VisitedSets {
 public:
  /// Room for 3/4 of 2^log2_slots sets.
  explicit VisitedSets(int log2_slots);

  void clear();

  /// Whether the set is new. Once there is no more room, no set is: a search ends rather than repeats itself.
  bool insert(std::uint64_t hash);

  bool contains(std::uint64_t hash) const { return slots_[findSlot(hash)].generation == generation_; }
  bool full() const { return 4 * count_ >= 3 * slots_.size(); }

 private:
  struct Slot {
    std::uint64_t hash = 0;
    std::uint32_t generation = 0;  ///< filled if that of the table
  };

  std::size_t findSlot(std::uint64_t hash) const;

  std::vector<Slot> slots_;
  std::size_t count_ = 0;
  std::uint32_t generation_ = 1;
};

}  // namespace sinew
