#include "sinew/solver/dense_kernels.h"

namespace sinew {

SINEW_DECLARE_PER_SET(const DenseKernels& denseKernels())

const DenseKernels& denseKernelsOf(InstructionSet set) {
  return SINEW_CALL_OF_SET(set, denseKernels);
}

}  // namespace sinew
