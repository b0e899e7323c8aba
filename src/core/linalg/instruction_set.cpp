#include "sinew/linalg/instruction_set.h"

#include <algorithm>
#include <cstdlib>

#include "sinew/common/config_error.h"

namespace sinew {

const char* nameOf(InstructionSet set) {
  switch (set) {
    case InstructionSet::kPlain:
      return "plain";
    case InstructionSet::kAvx2:
      return "avx2";
    case InstructionSet::kAvx512:
      return "avx512";
  }
  return "";
}

std::vector<InstructionSet> findInstructionSets() {
  std::vector<InstructionSet> sets = {InstructionSet::kPlain};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) sets.push_back(InstructionSet::kAvx2);
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl")) {
    sets.push_back(InstructionSet::kAvx512);
  }
#endif
  return sets;
}

InstructionSet chooseInstructionSet() {
  const std::vector<InstructionSet> sets = findInstructionSets();
  const char* wanted = std::getenv("SINEW_ISA");
  if (wanted == nullptr) return sets.back();
  std::string known;
  for (const InstructionSet set : sets) {
    if (std::string(wanted) == nameOf(set)) return set;
    known += std::string(known.empty() ? "" : ", ") + nameOf(set);
  }
  throw ConfigError("SINEW_ISA is " + std::string(wanted) + "; this machine has " + known);
}

}  // namespace sinew
