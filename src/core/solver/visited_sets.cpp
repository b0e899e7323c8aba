#include "sinew/solver/visited_sets.h"

#include <algorithm>

namespace sinew {

VisitedSets::VisitedSets(int log2_slots) : slots_(std::size_t{1} << log2_slots) {}

void VisitedSets::clear() {
  count_ = 0;
  if (++generation_ != 0) return;
  std::fill(slots_.begin(), slots_.end(), Slot());
  generation_ = 1;
}

bool VisitedSets::insert(std::uint64_t hash) {
  Slot& slot = slots_[findSlot(hash)];
  if (slot.generation == generation_ || full()) return false;
  slot = {hash, generation_};
  ++count_;
  return true;
}

/// The slot that holds the set, or the empty one where it belongs.
std::size_t VisitedSets::findSlot(std::uint64_t hash) const {
  const std::size_t mask = slots_.size() - 1;
  std::size_t k = static_cast<std::size_t>(hash) & mask;
  while (slots_[k].generation == generation_ && slots_[k].hash != hash) k = (k + 1) & mask;
  return k;
}

}  // namespace sinew
