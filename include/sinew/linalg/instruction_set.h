#pragma once

#include <string>
#include <vector>

namespace sinew {

/// Sets of vector instructions that the inner loops are compiled for; the best that a machine has is taken at run time.
enum class InstructionSet { kPlain, kAvx2, kAvx512 };

const char* nameOf(InstructionSet set);
/// Those that this machine can run, the plainest first.
std::vector<InstructionSet> findInstructionSets();
/// The best of them, or the one that the environment variable SINEW_ISA names (plain, avx2, avx512), if the machine has
/// it. Throws ConfigError for another name.
InstructionSet chooseInstructionSet();

}  // namespace sinew

// Declares a function of kernels once per set, each in the namespace of that set, and calls the one of a set.
#if defined(__x86_64__)
#define SINEW_DECLARE_PER_SET(declaration) \
  namespace plain {                        \
  declaration;                             \
  }                                        \
  namespace avx2 {                         \
  declaration;                             \
  }                                        \
  namespace avx512 {                       \
  declaration;                             \
  }
#define SINEW_CALL_OF_SET(set, function)                 \
  ((set) == InstructionSet::kAvx512 ? avx512::function() \
   : (set) == InstructionSet::kAvx2 ? avx2::function()   \
                                    : plain::function())
#else
#define SINEW_DECLARE_PER_SET(declaration) \
  namespace plain {                        \
  declaration;                             \
  }
#define SINEW_CALL_OF_SET(set, function) (static_cast<void>(set), plain::function())
#endif
