#pragma once

#include <sys/types.h>

#include <string>

namespace sinew {

/// What the kernel has counted for one thread.
struct ThreadUse {
  long minor_faults = -1;     ///< pages that had to be found, without a disk; negative where there is no such thread
  long major_faults = -1;     ///< with one
  double processor_time = 0;  ///< s
};

/// Process of a running node, asked of the node itself; -1 where there is none.
pid_t findProcess(const std::string& node);

/// Of the thread of that name in a process.
ThreadUse readThreadUse(pid_t process, const std::string& thread);

}  // namespace sinew
