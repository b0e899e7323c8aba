#pragma once

#include <string>

namespace sinew {

/// What a thread has asked of others, in a test that links thread_watch.cpp.
struct ThreadCounts {
  long allocations = 0;  ///< calls of malloc, calloc, realloc and what aligns, and so of operator new and of Eigen
  long locks = 0;        ///< calls of pthread_mutex_lock
};

/// Of the running thread of that name; zero where there is none or it has asked for nothing.
ThreadCounts countsOf(const std::string& thread);

/// Whether this build counts: not under the address sanitizer, which owns these functions.
bool watchesThreads();

}  // namespace sinew
