#pragma once

#include <cstddef>

namespace sinew {

/// Bytes of the largest single `operator new` since the last reset; a test that links largest_allocation.cpp has it.
std::size_t largestAllocation();
void resetLargestAllocation();

}  // namespace sinew
