#include "sinew/linalg/supernodal_kernels.h"

namespace sinew {

SINEW_DECLARE_PER_SET(const SupernodalKernels& supernodalKernels())

const SupernodalKernels& kernelsOf(InstructionSet set) {
  return SINEW_CALL_OF_SET(set, supernodalKernels);
}

}  // namespace sinew
