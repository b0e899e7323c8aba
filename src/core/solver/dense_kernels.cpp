#include "sinew/solver/dense_kernels.h"

namespace sinew {

namespace plain {
const DenseKernels& denseKernels();
}
#if defined(__x86_64__)
namespace avx2 {
const DenseKernels& denseKernels();
}
namespace avx512 {
const DenseKernels& denseKernels();
}
#endif

const DenseKernels& denseKernelsOf(InstructionSet set) {
  switch (set) {
#if defined(__x86_64__)
    case InstructionSet::kAvx2:
      return avx2::denseKernels();
    case InstructionSet::kAvx512:
      return avx512::denseKernels();
#endif
    default:
      return plain::denseKernels();
  }
}

}  // namespace sinew
