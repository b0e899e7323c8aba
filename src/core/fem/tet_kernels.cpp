#include "sinew/fem/tet_kernels.h"

namespace sinew {

SINEW_DECLARE_PER_SET(TetKernels tetKernels())

TetKernels tetKernelsOf(InstructionSet set) {
  return SINEW_CALL_OF_SET(set, tetKernels);
}

}  // namespace sinew
