#pragma once

namespace sinew {

/// Calls of malloc, calloc, realloc, aligned_alloc and posix_memalign so far, and so of operator new and of Eigen, in a
/// test that links allocation_count.cpp. Counts nothing under the address sanitizer, which owns these functions.
long allocationCount();

/// Whether this build counts.
bool countsAllocations();

}  // namespace sinew
