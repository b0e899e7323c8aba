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
